/* A device whose electronics are memory. */
#include "gimbal_bench.h"

static int32_t read_supply(void *context)
{
    const gimbal_bench_t *bench = context;
    return bench->supply;
}

static void actuate(void *context, int axis, const gimbal_actuation_t *wanted)
{
    gimbal_bench_t *bench = context;
    bench->wanted[axis] = *wanted;
}

static void sample(void *context, int axis, gimbal_sample_t *sampled)
{
    const gimbal_bench_t *bench = context;
    if (axis == 0 && bench->advance != NULL)
        bench->advance();
    *sampled = bench->samples[axis];
}

static void base(void *context, gimbal_base_t *now)
{
    const gimbal_bench_t *bench = context;
    *now = bench->base;
}

static void send(void *context, uint16_t id, const uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    gimbal_bench_t *bench = context;
    if (bench->sent_size + GIMBAL_RECORD_SIZE > GIMBAL_BENCH_MOST_SENT)
        return;
    uint8_t *record = &bench->sent[bench->sent_size];
    record[0] = (uint8_t)(id & 0xFFu);
    record[1] = (uint8_t)(id >> 8);
    for (uint32_t place = 0; place < GIMBAL_PAYLOAD_SIZE; ++place)
        record[2u + place] = payload[place];
    bench->sent_size += GIMBAL_RECORD_SIZE;
}

static void receive(void *context, uint16_t id, const uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    gimbal_bench_t *bench = context;
    (void)gimbal_device_receive(&bench->device, id, payload);
}

uint32_t gimbal_bench_size(void)
{
    return (uint32_t)sizeof(gimbal_bench_t);
}

void gimbal_bench_start(gimbal_bench_t *bench)
{
    bench->hardware.context = bench;
    bench->hardware.supply = read_supply;
    bench->hardware.actuate = actuate;
    bench->hardware.sample = sample;
    bench->hardware.base = base;
    bench->hardware.send = send;
    gimbal_device_start(&bench->device, &bench->settings, &bench->hardware);
}

void gimbal_bench_tick(gimbal_bench_t *bench, const uint8_t *block, uint32_t size)
{
    bench->sent_size = 0;
    gimbal_device_begin(&bench->device);
    for (uint32_t at = 0; at + GIMBAL_RECORD_SIZE <= size; at += GIMBAL_RECORD_SIZE)
        receive(bench, (uint16_t)(block[at] | (block[at + 1u] << 8)), &block[at + 2u]);
    gimbal_device_tick(&bench->device);
}

uint32_t gimbal_bench_line_tick(gimbal_bench_t *bench, const uint8_t *octets, uint32_t size)
{
    bench->sent_size = 0;
    gimbal_device_begin(&bench->device);
    for (uint32_t place = 0; place < size; ++place)
        (void)gimbal_stream_feed(&bench->stream, octets[place], receive, bench);
    gimbal_device_tick(&bench->device);
    for (uint32_t at = 0; at + GIMBAL_RECORD_SIZE <= bench->sent_size; at += GIMBAL_RECORD_SIZE) {
        const uint16_t id = (uint16_t)(bench->sent[at] | (bench->sent[at + 1u] << 8));
        (void)gimbal_packet_add(&bench->packet, id, &bench->sent[at + 2u]);
    }
    return gimbal_packet_end(&bench->packet);
}
