/* Frames on a serial line: blocks of ten-byte records in packets of COBS with CRC-16 (docs/reference/wire.md).
 * C11, no heap.
 *
 * A receiver keeps one packet and is right again after the next zero, whatever came before. Bad packets are counted.
 */
#ifndef GIMBAL_STREAM_H
#define GIMBAL_STREAM_H

#include <stddef.h>

#include "gimbal_protocol.h"

#ifdef __cplusplus
extern "C" {
#endif

#define GIMBAL_RECORD_SIZE 10u
/* most frames in a packet, bytes of such a block with its CRC, and of the longest packet without its delimiter */
#define GIMBAL_PACKET_FRAMES 48u
#define GIMBAL_SEALED_LIMIT (GIMBAL_PACKET_FRAMES * GIMBAL_RECORD_SIZE + 2u)
#define GIMBAL_PACKET_LIMIT (GIMBAL_SEALED_LIMIT + GIMBAL_SEALED_LIMIT / 254u + 1u)

/* What is done with each record of a good packet. */
typedef void (*gimbal_take_record_t)(void *context, uint16_t id, const uint8_t payload[GIMBAL_PAYLOAD_SIZE]);

typedef struct {
    uint8_t packet[GIMBAL_PACKET_LIMIT];
    uint32_t size;
    bool overflowed;
    uint32_t packets;
    uint32_t bad_coding;
    uint32_t bad_crc;
    uint32_t bad_length;
    uint32_t too_long;
} gimbal_stream_t;

/* CRC-16/CCITT-FALSE: polynomial 0x1021; start with 0xFFFF. Of "123456789" it is 0x29B1. */
uint16_t gimbal_crc16(uint16_t crc, const uint8_t *octets, uint32_t size);

/* One byte of the line; true when it completed a good packet, whose records were taken. */
bool gimbal_stream_feed(gimbal_stream_t *stream, uint8_t octet, gimbal_take_record_t take, void *context);

/* A packet under construction: records go in, `gimbal_packet_end` answers its bytes, delimiter included. */
typedef struct {
    uint8_t sealed[GIMBAL_SEALED_LIMIT];
    uint32_t size;
    uint8_t packet[GIMBAL_PACKET_LIMIT + 1u];
} gimbal_packet_t;

/* Add a record; false, and nothing added, when the packet is full. */
bool gimbal_packet_add(gimbal_packet_t *packet, uint16_t id, const uint8_t payload[GIMBAL_PAYLOAD_SIZE]);

/* Bytes of `packet->packet` that are to be sent, 0 without a record; the packet is empty again. */
uint32_t gimbal_packet_end(gimbal_packet_t *packet);

#ifdef __cplusplus
}
#endif

#endif /* GIMBAL_STREAM_H */
