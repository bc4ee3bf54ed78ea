/* A device on a bench: its electronics are memory that the caller reads and writes. For host libraries and simulators,
 * not for firmware.
 */
#ifndef GIMBAL_BENCH_H
#define GIMBAL_BENCH_H

#include "gimbal_device.h"
#include "gimbal_stream.h"

#define GIMBAL_BENCH_MOST_SENT (16u * GIMBAL_RECORD_SIZE)

typedef struct {
    gimbal_device_t device;
    gimbal_settings_t settings;
    gimbal_hardware_t hardware;
    gimbal_actuation_t wanted[GIMBAL_AXES];
    gimbal_sample_t samples[GIMBAL_AXES];
    gimbal_base_t base;
    int32_t supply;
    /* lets the tick pass: reads `wanted`, fills in `samples` and `base`; NULL where they are already there */
    void (*advance)(void);
    uint8_t sent[GIMBAL_BENCH_MOST_SENT];
    uint32_t sent_size;
    gimbal_stream_t stream;
    gimbal_packet_t packet;
} gimbal_bench_t;

/* Size of the structure, for those who lay it out again in another language. */
uint32_t gimbal_bench_size(void);

/* Start the device with `settings` as they stand. */
void gimbal_bench_start(gimbal_bench_t *bench);

/* One tick: a block of ten-byte records in, whatever is in it; `sent` holds `sent_size` bytes of records after it. */
void gimbal_bench_tick(gimbal_bench_t *bench, const uint8_t *block, uint32_t size);

/* The same with bytes of a serial line; `packet.packet` holds as many bytes as it answers. */
uint32_t gimbal_bench_line_tick(gimbal_bench_t *bench, const uint8_t *octets, uint32_t size);

#endif /* GIMBAL_BENCH_H */
