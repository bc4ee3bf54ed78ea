/* Packets of a serial line: COBS (Cheshire and Baker, IEEE/ACM Transactions on Networking 7, 1999) with CRC-16. */
#include "gimbal_stream.h"

#define CRC_SIZE 2u
/* a run of so many bytes without a zero ends a group of its own */
#define LONGEST_GROUP 255u

uint16_t gimbal_crc16(uint16_t crc, const uint8_t *octets, uint32_t size)
{
    for (uint32_t place = 0; place < size; ++place) {
        crc = (uint16_t)(crc ^ (uint16_t)((uint16_t)octets[place] << 8));
        for (int bit = 0; bit < 8; ++bit)
            crc = (uint16_t)((crc & 0x8000u) != 0u ? (uint16_t)(crc << 1) ^ 0x1021u : (uint16_t)(crc << 1));
    }
    return crc;
}

/* Decode in place; false when a group reaches beyond the end. */
static bool decode(uint8_t *octets, uint32_t size, uint32_t *decoded)
{
    uint32_t from = 0;
    uint32_t to = 0;
    while (from < size) {
        const uint32_t group = octets[from];
        if (group > size - from)
            return false;
        for (uint32_t place = 1; place < group; ++place) {
            octets[to] = octets[from + place];
            to += 1u;
        }
        from += group;
        if (group < LONGEST_GROUP && from < size) {
            octets[to] = 0;
            to += 1u;
        }
    }
    *decoded = to;
    return true;
}

static bool open_packet(gimbal_stream_t *stream, gimbal_take_record_t take, void *context)
{
    uint32_t size;
    if (!decode(stream->packet, stream->size, &size)) {
        stream->bad_coding += 1u;
        return false;
    }
    if (size <= CRC_SIZE || (size - CRC_SIZE) % GIMBAL_RECORD_SIZE != 0u) {
        stream->bad_length += 1u;
        return false;
    }
    /* a CRC over data and its own CRC is zero */
    if (gimbal_crc16(0xFFFFu, stream->packet, size) != 0u) {
        stream->bad_crc += 1u;
        return false;
    }
    stream->packets += 1u;
    for (uint32_t at = 0; at + CRC_SIZE < size; at += GIMBAL_RECORD_SIZE) {
        const uint16_t id = (uint16_t)(stream->packet[at] | (stream->packet[at + 1u] << 8));
        take(context, id, &stream->packet[at + 2u]);
    }
    return true;
}

bool gimbal_stream_feed(gimbal_stream_t *stream, uint8_t octet, gimbal_take_record_t take, void *context)
{
    if (octet != 0u) {
        if (stream->size < GIMBAL_PACKET_LIMIT) {
            stream->packet[stream->size] = octet;
            stream->size += 1u;
        } else if (!stream->overflowed) {
            stream->overflowed = true;
            stream->too_long += 1u;
        }
        return false;
    }
    const bool good = stream->size > 0u && !stream->overflowed && open_packet(stream, take, context);
    stream->size = 0;
    stream->overflowed = false;
    return good;
}

bool gimbal_packet_add(gimbal_packet_t *packet, uint16_t id, const uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    if (packet->size + GIMBAL_RECORD_SIZE + CRC_SIZE > GIMBAL_SEALED_LIMIT)
        return false;
    uint8_t *record = &packet->sealed[packet->size];
    record[0] = (uint8_t)(id & 0xFFu);
    record[1] = (uint8_t)(id >> 8);
    for (uint32_t place = 0; place < GIMBAL_PAYLOAD_SIZE; ++place)
        record[2u + place] = payload[place];
    packet->size += GIMBAL_RECORD_SIZE;
    return true;
}

uint32_t gimbal_packet_end(gimbal_packet_t *packet)
{
    if (packet->size == 0u)
        return 0;
    const uint16_t crc = gimbal_crc16(0xFFFFu, packet->sealed, packet->size);
    const uint32_t size = packet->size + CRC_SIZE;
    packet->sealed[packet->size] = (uint8_t)(crc >> 8);
    packet->sealed[packet->size + 1u] = (uint8_t)(crc & 0xFFu);
    uint32_t group_at = 0;
    uint32_t to = 1;
    uint32_t group = 1;
    for (uint32_t from = 0; from < size; ++from) {
        if (packet->sealed[from] != 0u) {
            packet->packet[to] = packet->sealed[from];
            to += 1u;
            group += 1u;
        }
        /* a group that is full at the very end needs none behind it */
        if (packet->sealed[from] == 0u || (group == LONGEST_GROUP && from + 1u < size)) {
            packet->packet[group_at] = (uint8_t)group;
            group_at = to;
            to += 1u;
            group = 1;
        }
    }
    packet->packet[group_at] = (uint8_t)group;
    packet->packet[to] = 0;
    packet->size = 0;
    return to + 1u;
}
