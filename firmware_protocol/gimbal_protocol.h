/* The wire of the gimballed antenna, for firmware. C99.
 *
 * Emitted from the schema by `gimbal-hil protocol --emit c`; do not edit.
 *
 * A payload is eight bytes: fields in bits 0..47 of a little-endian word, alive counter in bits 48..51, CRC in bits
 * 52..63. Structures hold raw integers; physical value = raw * GIMBAL_..._STEP. Packing holds a number at its bounds.
 */
#ifndef GIMBAL_PROTOCOL_H
#define GIMBAL_PROTOCOL_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define GIMBAL_PAYLOAD_SIZE 8
#define GIMBAL_PROTOCOL_VERSION 2u

/* What a receiver does (docs/reference/wire.md): the counter of a message is forgotten after so many of its periods of
   silence, of a message sent on an event after so many ticks; a counter that many steps ahead is a late frame. */
#define GIMBAL_LOST_PERIODS 10u
#define GIMBAL_EVENT_MEMORY_TICKS 100u
#define GIMBAL_LATE_STEP 12u
#define GIMBAL_UNKNOWN_COUNTER (-1)

/* The edge of a tick in lockstep over a link, for simulated boards (docs/reference/wire.md); a device with a clock
   drops it. */
#define GIMBAL_EDGE_ID 0x7F0u
#define GIMBAL_EDGE_DATA_ID 0x7Fu

/* States of the drive after CiA 402 (IEC 61800-7-201). */
enum gimbal_drive_state {
    GIMBAL_DRIVE_STATE_NOT_READY = 0,
    GIMBAL_DRIVE_STATE_SWITCH_ON_DISABLED = 1,
    GIMBAL_DRIVE_STATE_READY_TO_SWITCH_ON = 2,
    GIMBAL_DRIVE_STATE_SWITCHED_ON = 3,
    GIMBAL_DRIVE_STATE_OPERATION_ENABLED = 4,
    GIMBAL_DRIVE_STATE_QUICK_STOP_ACTIVE = 5,
    GIMBAL_DRIVE_STATE_FAULT_REACTION_ACTIVE = 6,
    GIMBAL_DRIVE_STATE_FAULT = 7
};

/* Commands of the CiA 402 state machine; faults are reset by an edge of `fault_reset`. */
enum gimbal_drive_request {
    GIMBAL_DRIVE_REQUEST_NONE = 0,
    GIMBAL_DRIVE_REQUEST_SHUTDOWN = 1,
    GIMBAL_DRIVE_REQUEST_SWITCH_ON = 2,
    GIMBAL_DRIVE_REQUEST_ENABLE_OPERATION = 3,
    GIMBAL_DRIVE_REQUEST_DISABLE_OPERATION = 4,
    GIMBAL_DRIVE_REQUEST_DISABLE_VOLTAGE = 5,
    GIMBAL_DRIVE_REQUEST_QUICK_STOP = 6
};

/* Why the drive is in fault, or why its state changed. */
enum gimbal_fault_code {
    GIMBAL_FAULT_CODE_NONE = 0,
    GIMBAL_FAULT_CODE_DEADMAN = 1,
    GIMBAL_FAULT_CODE_TRAVEL_LIMIT = 2,
    GIMBAL_FAULT_CODE_OVERSPEED = 3,
    GIMBAL_FAULT_CODE_OVERTEMPERATURE = 4,
    GIMBAL_FAULT_CODE_UNDERVOLTAGE = 5,
    GIMBAL_FAULT_CODE_COMMUNICATION = 6,
    GIMBAL_FAULT_CODE_ENCODER = 7,
    GIMBAL_FAULT_CODE_GYRO = 8,
    GIMBAL_FAULT_CODE_INTERNAL = 9,
    GIMBAL_FAULT_CODE_SENSORS_DISAGREE = 10,
    GIMBAL_FAULT_CODE_SENSOR_STUCK = 11,
    GIMBAL_FAULT_CODE_RUNAWAY = 12,
    GIMBAL_FAULT_CODE_HOLDING_BRAKE = 13
};

/* How the drive stops: no torque; shorted winding; ramp to rest and hold, by encoder alone; torque against the
    rate, by gyro alone. */
enum gimbal_stop_reaction {
    GIMBAL_STOP_REACTION_COAST = 0,
    GIMBAL_STOP_REACTION_BRAKE = 1,
    GIMBAL_STOP_REACTION_DECELERATE_AND_HOLD = 2,
    GIMBAL_STOP_REACTION_GYRO_STOP = 3
};

/* What the host asks of an axis' holding brake; AUTOMATIC engages it whenever no axis is under torque. */
enum gimbal_brake_command {
    GIMBAL_BRAKE_COMMAND_AUTOMATIC = 0,
    GIMBAL_BRAKE_COMMAND_ENGAGE = 1,
    GIMBAL_BRAKE_COMMAND_RELEASE = 2
};

/* Where an axis' holding brake stands. */
enum gimbal_brake_state {
    GIMBAL_BRAKE_STATE_ABSENT = 0,
    GIMBAL_BRAKE_STATE_RELEASED = 1,
    GIMBAL_BRAKE_STATE_ENGAGED = 2
};

/* Limits that act at this tick. */
enum gimbal_limit_flags {
    GIMBAL_LIMIT_FLAGS_OUTER_TORQUE = 1,
    GIMBAL_LIMIT_FLAGS_INNER_TORQUE = 2,
    GIMBAL_LIMIT_FLAGS_OUTER_TRAVEL_LOW = 4,
    GIMBAL_LIMIT_FLAGS_OUTER_TRAVEL_HIGH = 8,
    GIMBAL_LIMIT_FLAGS_INNER_TRAVEL_LOW = 16,
    GIMBAL_LIMIT_FLAGS_INNER_TRAVEL_HIGH = 32,
    GIMBAL_LIMIT_FLAGS_OUTER_RATE = 64,
    GIMBAL_LIMIT_FLAGS_INNER_RATE = 128
};

/* CRC-12: polynomial 0x75D, start 0; of "123456789" it is 0x6DD. */
static inline uint16_t gimbal_crc12_byte(uint16_t crc, uint8_t octet)
{
    crc ^= (uint16_t)((uint16_t)octet << 4);
    for (int bit = 0; bit < 8; ++bit)
        crc = (uint16_t)((crc & 0x800u) ? (uint16_t)(crc << 1) ^ 0x75Du : (uint16_t)(crc << 1));
    return crc & 0xFFFu;
}

/* CRC of a payload: data id, low half of byte 6, bytes 0..5. */
static inline uint16_t gimbal_crc12(uint8_t data_id, const uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    uint16_t crc = gimbal_crc12_byte(gimbal_crc12_byte(0, data_id), (uint8_t)(payload[6] & 0x0Fu));
    for (int place = 0; place < 6; ++place)
        crc = gimbal_crc12_byte(crc, payload[place]);
    return crc;
}

/* Puts fields, counter and CRC into a payload. */
static inline void gimbal_seal(uint8_t data_id, uint64_t fields, uint8_t counter, uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    for (int place = 0; place < 6; ++place)
        payload[place] = (uint8_t)(fields >> (8 * place));
    payload[6] = (uint8_t)(counter & 0x0Fu);
    const uint16_t crc = gimbal_crc12(data_id, payload);
    payload[6] = (uint8_t)(payload[6] | (uint8_t)((crc & 0x0Fu) << 4));
    payload[7] = (uint8_t)(crc >> 4);
}

/* Takes the fields out of a payload; false when its CRC is wrong. */
static inline bool gimbal_unseal(uint8_t data_id, const uint8_t payload[GIMBAL_PAYLOAD_SIZE], uint64_t *fields)
{
    if (gimbal_crc12(data_id, payload) != (uint16_t)((payload[6] >> 4) | (payload[7] << 4)))
        return false;
    *fields = 0;
    for (int place = 0; place < 6; ++place)
        *fields |= (uint64_t)payload[place] << (8 * place);
    return true;
}

/* Alive counter of a payload. */
static inline uint8_t gimbal_alive_counter(const uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    return payload[6] & 0x0Fu;
}

static inline int32_t gimbal_hold(int32_t raw, int32_t low, int32_t high)
{
    return raw < low ? low : raw > high ? high : raw;
}

static inline uint64_t gimbal_insert(uint64_t word, int start, int bits, int32_t raw)
{
    return word | (((uint64_t)(int64_t)raw & ((UINT64_C(1) << bits) - 1u)) << start);
}

static inline int32_t gimbal_extract(uint64_t word, int start, int bits, bool is_signed)
{
    const int64_t raw = (int64_t)((word >> start) & ((UINT64_C(1) << bits) - 1u));
    return (int32_t)(is_signed && (raw >> (bits - 1)) ? raw - ((int64_t)1 << bits) : raw);
}

/* drive_control, host to device:
   drive state requests, on change and repeated */
#define GIMBAL_DRIVE_CONTROL_ID 0x010u
#define GIMBAL_DRIVE_CONTROL_DATA_ID 0x01u
#define GIMBAL_DRIVE_CONTROL_PERIOD_TICKS 100u

typedef struct {
    uint8_t request; /* state wanted, as a CiA 402 command */
    bool fault_reset; /* a rising edge leaves FAULT */
    bool quick_stop; /* stop now, whatever the request */
    bool clear_travel; /* allow torque that leads back from a travel limit */
    uint8_t stop; /* how a quick stop stops */
    uint8_t brake_outer; /* holding brake of the outer axis */
    uint8_t brake_inner; /* holding brake of the inner axis */
    bool identify; /* the antenna may say at once who it is */
} gimbal_drive_control_t;

static inline void gimbal_drive_control_pack(const gimbal_drive_control_t *message, uint8_t counter,
    uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    uint64_t fields = 0;
    fields = gimbal_insert(fields, 0, 4, gimbal_hold((int32_t)message->request, 0, 6));
    fields = gimbal_insert(fields, 4, 1, (int32_t)message->fault_reset);
    fields = gimbal_insert(fields, 5, 1, (int32_t)message->quick_stop);
    fields = gimbal_insert(fields, 6, 1, (int32_t)message->clear_travel);
    fields = gimbal_insert(fields, 7, 3, gimbal_hold((int32_t)message->stop, 0, 3));
    fields = gimbal_insert(fields, 10, 2, gimbal_hold((int32_t)message->brake_outer, 0, 2));
    fields = gimbal_insert(fields, 12, 2, gimbal_hold((int32_t)message->brake_inner, 0, 2));
    fields = gimbal_insert(fields, 14, 1, (int32_t)message->identify);
    gimbal_seal(GIMBAL_DRIVE_CONTROL_DATA_ID, fields, counter, payload);
}

/* From fields whose CRC is right. False, and nothing written, when a field is out of its bounds. */
static inline bool gimbal_drive_control_read(uint64_t fields, gimbal_drive_control_t *message)
{
    const int32_t request = gimbal_extract(fields, 0, 4, false);
    const int32_t fault_reset = gimbal_extract(fields, 4, 1, false);
    const int32_t quick_stop = gimbal_extract(fields, 5, 1, false);
    const int32_t clear_travel = gimbal_extract(fields, 6, 1, false);
    const int32_t stop = gimbal_extract(fields, 7, 3, false);
    const int32_t brake_outer = gimbal_extract(fields, 10, 2, false);
    const int32_t brake_inner = gimbal_extract(fields, 12, 2, false);
    const int32_t identify = gimbal_extract(fields, 14, 1, false);
    if (request < 0 || request > 6)
        return false;
    if (stop < 0 || stop > 3)
        return false;
    if (brake_outer < 0 || brake_outer > 2)
        return false;
    if (brake_inner < 0 || brake_inner > 2)
        return false;
    message->request = (uint8_t)request;
    message->fault_reset = fault_reset != 0;
    message->quick_stop = quick_stop != 0;
    message->clear_travel = clear_travel != 0;
    message->stop = (uint8_t)stop;
    message->brake_outer = (uint8_t)brake_outer;
    message->brake_inner = (uint8_t)brake_inner;
    message->identify = identify != 0;
    return true;
}

/* False, and nothing written, when the CRC or a field is wrong. */
static inline bool gimbal_drive_control_unpack(const uint8_t payload[GIMBAL_PAYLOAD_SIZE],
    gimbal_drive_control_t *message)
{
    uint64_t fields;
    if (!gimbal_unseal(GIMBAL_DRIVE_CONTROL_DATA_ID, payload, &fields))
        return false;
    return gimbal_drive_control_read(fields, message);
}

/* set_point, host to device:
   torque of both axes; a fresh one feeds the deadman */
#define GIMBAL_SET_POINT_ID 0x020u
#define GIMBAL_SET_POINT_DATA_ID 0x02u
#define GIMBAL_SET_POINT_PERIOD_TICKS 1u
#define GIMBAL_SET_POINT_TORQUE_OUTER_STEP 0.000125 /* N m */
#define GIMBAL_SET_POINT_TORQUE_INNER_STEP 0.000125 /* N m */
#define GIMBAL_SET_POINT_TORQUE_OUTER_LOW (-131072)
#define GIMBAL_SET_POINT_TORQUE_OUTER_HIGH 131071
#define GIMBAL_SET_POINT_TORQUE_INNER_LOW (-131072)
#define GIMBAL_SET_POINT_TORQUE_INNER_HIGH 131071

typedef struct {
    int32_t torque_outer; /* torque of the outer axis, held for one tick */
    int32_t torque_inner; /* torque of the inner axis, held for one tick */
    uint16_t sequence; /* number of the tick, modulo 1024 */
    bool enable_outer; /* the outer axis may apply torque */
    bool enable_inner; /* the inner axis may apply torque */
} gimbal_set_point_t;

static inline void gimbal_set_point_pack(const gimbal_set_point_t *message, uint8_t counter,
    uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    uint64_t fields = 0;
    fields = gimbal_insert(fields, 0, 18, gimbal_hold((int32_t)message->torque_outer, -131072, 131071));
    fields = gimbal_insert(fields, 18, 18, gimbal_hold((int32_t)message->torque_inner, -131072, 131071));
    fields = gimbal_insert(fields, 36, 10, gimbal_hold((int32_t)message->sequence, 0, 1023));
    fields = gimbal_insert(fields, 46, 1, (int32_t)message->enable_outer);
    fields = gimbal_insert(fields, 47, 1, (int32_t)message->enable_inner);
    gimbal_seal(GIMBAL_SET_POINT_DATA_ID, fields, counter, payload);
}

/* From fields whose CRC is right. False, and nothing written, when a field is out of its bounds. */
static inline bool gimbal_set_point_read(uint64_t fields, gimbal_set_point_t *message)
{
    const int32_t torque_outer = gimbal_extract(fields, 0, 18, true);
    const int32_t torque_inner = gimbal_extract(fields, 18, 18, true);
    const int32_t sequence = gimbal_extract(fields, 36, 10, false);
    const int32_t enable_outer = gimbal_extract(fields, 46, 1, false);
    const int32_t enable_inner = gimbal_extract(fields, 47, 1, false);
    message->torque_outer = (int32_t)torque_outer;
    message->torque_inner = (int32_t)torque_inner;
    message->sequence = (uint16_t)sequence;
    message->enable_outer = enable_outer != 0;
    message->enable_inner = enable_inner != 0;
    return true;
}

/* False, and nothing written, when the CRC or a field is wrong. */
static inline bool gimbal_set_point_unpack(const uint8_t payload[GIMBAL_PAYLOAD_SIZE],
    gimbal_set_point_t *message)
{
    uint64_t fields;
    if (!gimbal_unseal(GIMBAL_SET_POINT_DATA_ID, payload, &fields))
        return false;
    return gimbal_set_point_read(fields, message);
}

/* deadman_config, host to device:
   deadman, sent at connection */
#define GIMBAL_DEADMAN_CONFIG_ID 0x030u
#define GIMBAL_DEADMAN_CONFIG_DATA_ID 0x03u
#define GIMBAL_DEADMAN_CONFIG_PERIOD_TICKS 0u

typedef struct {
    uint8_t window_ticks; /* ticks without a fresh set-point before the reaction */
    uint8_t reaction; /* what the drive does then */
} gimbal_deadman_config_t;

static inline void gimbal_deadman_config_pack(const gimbal_deadman_config_t *message, uint8_t counter,
    uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    uint64_t fields = 0;
    fields = gimbal_insert(fields, 0, 8, gimbal_hold((int32_t)message->window_ticks, 1, 255));
    fields = gimbal_insert(fields, 8, 3, gimbal_hold((int32_t)message->reaction, 0, 3));
    gimbal_seal(GIMBAL_DEADMAN_CONFIG_DATA_ID, fields, counter, payload);
}

/* From fields whose CRC is right. False, and nothing written, when a field is out of its bounds. */
static inline bool gimbal_deadman_config_read(uint64_t fields, gimbal_deadman_config_t *message)
{
    const int32_t window_ticks = gimbal_extract(fields, 0, 8, false);
    const int32_t reaction = gimbal_extract(fields, 8, 3, false);
    if (window_ticks < 1 || window_ticks > 255)
        return false;
    if (reaction < 0 || reaction > 3)
        return false;
    message->window_ticks = (uint8_t)window_ticks;
    message->reaction = (uint8_t)reaction;
    return true;
}

/* False, and nothing written, when the CRC or a field is wrong. */
static inline bool gimbal_deadman_config_unpack(const uint8_t payload[GIMBAL_PAYLOAD_SIZE],
    gimbal_deadman_config_t *message)
{
    uint64_t fields;
    if (!gimbal_unseal(GIMBAL_DEADMAN_CONFIG_DATA_ID, payload, &fields))
        return false;
    return gimbal_deadman_config_read(fields, message);
}

/* feedback_outer, device to host:
   sensors of the outer axis, sampled at this tick */
#define GIMBAL_FEEDBACK_OUTER_ID 0x110u
#define GIMBAL_FEEDBACK_OUTER_DATA_ID 0x11u
#define GIMBAL_FEEDBACK_OUTER_PERIOD_TICKS 1u
#define GIMBAL_FEEDBACK_OUTER_POSITION_STEP 1.4980281131695715e-06 /* rad */
#define GIMBAL_FEEDBACK_OUTER_RATE_STEP 1e-05 /* rad/s */
#define GIMBAL_FEEDBACK_OUTER_POSITION_LOW (-33554432)
#define GIMBAL_FEEDBACK_OUTER_POSITION_HIGH 33554431
#define GIMBAL_FEEDBACK_OUTER_RATE_LOW (-2097152)
#define GIMBAL_FEEDBACK_OUTER_RATE_HIGH 2097151

typedef struct {
    int32_t position; /* joint angle from the encoder, multi-turn */
    int32_t rate; /* inertial rate about the axis from the gyro */
} gimbal_feedback_outer_t;

static inline void gimbal_feedback_outer_pack(const gimbal_feedback_outer_t *message, uint8_t counter,
    uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    uint64_t fields = 0;
    fields = gimbal_insert(fields, 0, 26, gimbal_hold((int32_t)message->position, -33554432, 33554431));
    fields = gimbal_insert(fields, 26, 22, gimbal_hold((int32_t)message->rate, -2097152, 2097151));
    gimbal_seal(GIMBAL_FEEDBACK_OUTER_DATA_ID, fields, counter, payload);
}

/* From fields whose CRC is right. False, and nothing written, when a field is out of its bounds. */
static inline bool gimbal_feedback_outer_read(uint64_t fields, gimbal_feedback_outer_t *message)
{
    const int32_t position = gimbal_extract(fields, 0, 26, true);
    const int32_t rate = gimbal_extract(fields, 26, 22, true);
    message->position = (int32_t)position;
    message->rate = (int32_t)rate;
    return true;
}

/* False, and nothing written, when the CRC or a field is wrong. */
static inline bool gimbal_feedback_outer_unpack(const uint8_t payload[GIMBAL_PAYLOAD_SIZE],
    gimbal_feedback_outer_t *message)
{
    uint64_t fields;
    if (!gimbal_unseal(GIMBAL_FEEDBACK_OUTER_DATA_ID, payload, &fields))
        return false;
    return gimbal_feedback_outer_read(fields, message);
}

/* feedback_inner, device to host:
   sensors of the inner axis, sampled at this tick */
#define GIMBAL_FEEDBACK_INNER_ID 0x120u
#define GIMBAL_FEEDBACK_INNER_DATA_ID 0x12u
#define GIMBAL_FEEDBACK_INNER_PERIOD_TICKS 1u
#define GIMBAL_FEEDBACK_INNER_POSITION_STEP 1.4980281131695715e-06 /* rad */
#define GIMBAL_FEEDBACK_INNER_RATE_STEP 1e-05 /* rad/s */
#define GIMBAL_FEEDBACK_INNER_POSITION_LOW (-33554432)
#define GIMBAL_FEEDBACK_INNER_POSITION_HIGH 33554431
#define GIMBAL_FEEDBACK_INNER_RATE_LOW (-2097152)
#define GIMBAL_FEEDBACK_INNER_RATE_HIGH 2097151

typedef struct {
    int32_t position; /* joint angle from the encoder, multi-turn */
    int32_t rate; /* inertial rate about the axis from the gyro */
} gimbal_feedback_inner_t;

static inline void gimbal_feedback_inner_pack(const gimbal_feedback_inner_t *message, uint8_t counter,
    uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    uint64_t fields = 0;
    fields = gimbal_insert(fields, 0, 26, gimbal_hold((int32_t)message->position, -33554432, 33554431));
    fields = gimbal_insert(fields, 26, 22, gimbal_hold((int32_t)message->rate, -2097152, 2097151));
    gimbal_seal(GIMBAL_FEEDBACK_INNER_DATA_ID, fields, counter, payload);
}

/* From fields whose CRC is right. False, and nothing written, when a field is out of its bounds. */
static inline bool gimbal_feedback_inner_read(uint64_t fields, gimbal_feedback_inner_t *message)
{
    const int32_t position = gimbal_extract(fields, 0, 26, true);
    const int32_t rate = gimbal_extract(fields, 26, 22, true);
    message->position = (int32_t)position;
    message->rate = (int32_t)rate;
    return true;
}

/* False, and nothing written, when the CRC or a field is wrong. */
static inline bool gimbal_feedback_inner_unpack(const uint8_t payload[GIMBAL_PAYLOAD_SIZE],
    gimbal_feedback_inner_t *message)
{
    uint64_t fields;
    if (!gimbal_unseal(GIMBAL_FEEDBACK_INNER_DATA_ID, payload, &fields))
        return false;
    return gimbal_feedback_inner_read(fields, message);
}

/* drive_status, device to host:
   state of the drive; closes the feedback set of a tick */
#define GIMBAL_DRIVE_STATUS_ID 0x130u
#define GIMBAL_DRIVE_STATUS_DATA_ID 0x13u
#define GIMBAL_DRIVE_STATUS_PERIOD_TICKS 1u

typedef struct {
    uint8_t state; /* drive state */
    uint8_t fault; /* latched fault */
    uint16_t last_sequence; /* sequence of the set-point that acted before this sample */
    uint8_t deadman_margin; /* ticks left before the deadman reacts */
    uint8_t limits; /* limits that act now */
    uint16_t tick; /* the device's tick, modulo 4096 */
} gimbal_drive_status_t;

static inline void gimbal_drive_status_pack(const gimbal_drive_status_t *message, uint8_t counter,
    uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    uint64_t fields = 0;
    fields = gimbal_insert(fields, 0, 4, gimbal_hold((int32_t)message->state, 0, 7));
    fields = gimbal_insert(fields, 4, 6, gimbal_hold((int32_t)message->fault, 0, 13));
    fields = gimbal_insert(fields, 10, 10, gimbal_hold((int32_t)message->last_sequence, 0, 1023));
    fields = gimbal_insert(fields, 20, 8, gimbal_hold((int32_t)message->deadman_margin, 0, 255));
    fields = gimbal_insert(fields, 28, 8, gimbal_hold((int32_t)message->limits, 0, 255));
    fields = gimbal_insert(fields, 36, 12, gimbal_hold((int32_t)message->tick, 0, 4095));
    gimbal_seal(GIMBAL_DRIVE_STATUS_DATA_ID, fields, counter, payload);
}

/* From fields whose CRC is right. False, and nothing written, when a field is out of its bounds. */
static inline bool gimbal_drive_status_read(uint64_t fields, gimbal_drive_status_t *message)
{
    const int32_t state = gimbal_extract(fields, 0, 4, false);
    const int32_t fault = gimbal_extract(fields, 4, 6, false);
    const int32_t last_sequence = gimbal_extract(fields, 10, 10, false);
    const int32_t deadman_margin = gimbal_extract(fields, 20, 8, false);
    const int32_t limits = gimbal_extract(fields, 28, 8, false);
    const int32_t tick = gimbal_extract(fields, 36, 12, false);
    if (state < 0 || state > 7)
        return false;
    if (fault < 0 || fault > 13)
        return false;
    message->state = (uint8_t)state;
    message->fault = (uint8_t)fault;
    message->last_sequence = (uint16_t)last_sequence;
    message->deadman_margin = (uint8_t)deadman_margin;
    message->limits = (uint8_t)limits;
    message->tick = (uint16_t)tick;
    return true;
}

/* False, and nothing written, when the CRC or a field is wrong. */
static inline bool gimbal_drive_status_unpack(const uint8_t payload[GIMBAL_PAYLOAD_SIZE],
    gimbal_drive_status_t *message)
{
    uint64_t fields;
    if (!gimbal_unseal(GIMBAL_DRIVE_STATUS_DATA_ID, payload, &fields))
        return false;
    return gimbal_drive_status_read(fields, message);
}

/* motor_status_outer, device to host:
   motor of the outer axis */
#define GIMBAL_MOTOR_STATUS_OUTER_ID 0x140u
#define GIMBAL_MOTOR_STATUS_OUTER_DATA_ID 0x14u
#define GIMBAL_MOTOR_STATUS_OUTER_PERIOD_TICKS 50u
#define GIMBAL_MOTOR_STATUS_OUTER_TORQUE_STEP 0.000125 /* N m */
#define GIMBAL_MOTOR_STATUS_OUTER_TEMPERATURE_STEP 0.1 /* degC */
#define GIMBAL_MOTOR_STATUS_OUTER_SUPPLY_STEP 0.02 /* V */
#define GIMBAL_MOTOR_STATUS_OUTER_TORQUE_LOW (-131072)
#define GIMBAL_MOTOR_STATUS_OUTER_TORQUE_HIGH 131071
#define GIMBAL_MOTOR_STATUS_OUTER_TEMPERATURE_LOW (-2048)
#define GIMBAL_MOTOR_STATUS_OUTER_TEMPERATURE_HIGH 2047

typedef struct {
    int32_t torque; /* torque measured at the actuator, from motor current */
    int16_t temperature; /* winding temperature */
    uint16_t supply; /* supply voltage */
    uint8_t brake; /* holding brake */
    bool shorted; /* the drive has shorted this winding */
} gimbal_motor_status_outer_t;

static inline void gimbal_motor_status_outer_pack(const gimbal_motor_status_outer_t *message, uint8_t counter,
    uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    uint64_t fields = 0;
    fields = gimbal_insert(fields, 0, 18, gimbal_hold((int32_t)message->torque, -131072, 131071));
    fields = gimbal_insert(fields, 18, 12, gimbal_hold((int32_t)message->temperature, -2048, 2047));
    fields = gimbal_insert(fields, 30, 12, gimbal_hold((int32_t)message->supply, 0, 4095));
    fields = gimbal_insert(fields, 42, 2, gimbal_hold((int32_t)message->brake, 0, 2));
    fields = gimbal_insert(fields, 44, 1, (int32_t)message->shorted);
    gimbal_seal(GIMBAL_MOTOR_STATUS_OUTER_DATA_ID, fields, counter, payload);
}

/* From fields whose CRC is right. False, and nothing written, when a field is out of its bounds. */
static inline bool gimbal_motor_status_outer_read(uint64_t fields, gimbal_motor_status_outer_t *message)
{
    const int32_t torque = gimbal_extract(fields, 0, 18, true);
    const int32_t temperature = gimbal_extract(fields, 18, 12, true);
    const int32_t supply = gimbal_extract(fields, 30, 12, false);
    const int32_t brake = gimbal_extract(fields, 42, 2, false);
    const int32_t shorted = gimbal_extract(fields, 44, 1, false);
    if (brake < 0 || brake > 2)
        return false;
    message->torque = (int32_t)torque;
    message->temperature = (int16_t)temperature;
    message->supply = (uint16_t)supply;
    message->brake = (uint8_t)brake;
    message->shorted = shorted != 0;
    return true;
}

/* False, and nothing written, when the CRC or a field is wrong. */
static inline bool gimbal_motor_status_outer_unpack(const uint8_t payload[GIMBAL_PAYLOAD_SIZE],
    gimbal_motor_status_outer_t *message)
{
    uint64_t fields;
    if (!gimbal_unseal(GIMBAL_MOTOR_STATUS_OUTER_DATA_ID, payload, &fields))
        return false;
    return gimbal_motor_status_outer_read(fields, message);
}

/* motor_status_inner, device to host:
   motor of the inner axis */
#define GIMBAL_MOTOR_STATUS_INNER_ID 0x150u
#define GIMBAL_MOTOR_STATUS_INNER_DATA_ID 0x15u
#define GIMBAL_MOTOR_STATUS_INNER_PERIOD_TICKS 50u
#define GIMBAL_MOTOR_STATUS_INNER_TORQUE_STEP 0.000125 /* N m */
#define GIMBAL_MOTOR_STATUS_INNER_TEMPERATURE_STEP 0.1 /* degC */
#define GIMBAL_MOTOR_STATUS_INNER_SUPPLY_STEP 0.02 /* V */
#define GIMBAL_MOTOR_STATUS_INNER_TORQUE_LOW (-131072)
#define GIMBAL_MOTOR_STATUS_INNER_TORQUE_HIGH 131071
#define GIMBAL_MOTOR_STATUS_INNER_TEMPERATURE_LOW (-2048)
#define GIMBAL_MOTOR_STATUS_INNER_TEMPERATURE_HIGH 2047

typedef struct {
    int32_t torque; /* torque measured at the actuator, from motor current */
    int16_t temperature; /* winding temperature */
    uint16_t supply; /* supply voltage */
    uint8_t brake; /* holding brake */
    bool shorted; /* the drive has shorted this winding */
} gimbal_motor_status_inner_t;

static inline void gimbal_motor_status_inner_pack(const gimbal_motor_status_inner_t *message, uint8_t counter,
    uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    uint64_t fields = 0;
    fields = gimbal_insert(fields, 0, 18, gimbal_hold((int32_t)message->torque, -131072, 131071));
    fields = gimbal_insert(fields, 18, 12, gimbal_hold((int32_t)message->temperature, -2048, 2047));
    fields = gimbal_insert(fields, 30, 12, gimbal_hold((int32_t)message->supply, 0, 4095));
    fields = gimbal_insert(fields, 42, 2, gimbal_hold((int32_t)message->brake, 0, 2));
    fields = gimbal_insert(fields, 44, 1, (int32_t)message->shorted);
    gimbal_seal(GIMBAL_MOTOR_STATUS_INNER_DATA_ID, fields, counter, payload);
}

/* From fields whose CRC is right. False, and nothing written, when a field is out of its bounds. */
static inline bool gimbal_motor_status_inner_read(uint64_t fields, gimbal_motor_status_inner_t *message)
{
    const int32_t torque = gimbal_extract(fields, 0, 18, true);
    const int32_t temperature = gimbal_extract(fields, 18, 12, true);
    const int32_t supply = gimbal_extract(fields, 30, 12, false);
    const int32_t brake = gimbal_extract(fields, 42, 2, false);
    const int32_t shorted = gimbal_extract(fields, 44, 1, false);
    if (brake < 0 || brake > 2)
        return false;
    message->torque = (int32_t)torque;
    message->temperature = (int16_t)temperature;
    message->supply = (uint16_t)supply;
    message->brake = (uint8_t)brake;
    message->shorted = shorted != 0;
    return true;
}

/* False, and nothing written, when the CRC or a field is wrong. */
static inline bool gimbal_motor_status_inner_unpack(const uint8_t payload[GIMBAL_PAYLOAD_SIZE],
    gimbal_motor_status_inner_t *message)
{
    uint64_t fields;
    if (!gimbal_unseal(GIMBAL_MOTOR_STATUS_INNER_DATA_ID, payload, &fields))
        return false;
    return gimbal_motor_status_inner_read(fields, message);
}

/* base_attitude, device to host:
   attitude of the base, R_eb = Rz(yaw) Ry(pitch) Rx(roll); base_heading in the next tick closes the set */
#define GIMBAL_BASE_ATTITUDE_ID 0x160u
#define GIMBAL_BASE_ATTITUDE_DATA_ID 0x16u
#define GIMBAL_BASE_ATTITUDE_PERIOD_TICKS 10u
#define GIMBAL_BASE_ATTITUDE_ROLL_STEP 2e-06 /* rad */
#define GIMBAL_BASE_ATTITUDE_PITCH_STEP 2e-06 /* rad */
#define GIMBAL_BASE_ATTITUDE_ROLL_LOW (-2097152)
#define GIMBAL_BASE_ATTITUDE_ROLL_HIGH 2097151
#define GIMBAL_BASE_ATTITUDE_PITCH_LOW (-2097152)
#define GIMBAL_BASE_ATTITUDE_PITCH_HIGH 2097151

typedef struct {
    int32_t roll; /* base roll */
    int32_t pitch; /* base pitch */
    uint8_t set; /* lowest bits of the `valid_tick` of the base_heading that belongs to it */
} gimbal_base_attitude_t;

static inline void gimbal_base_attitude_pack(const gimbal_base_attitude_t *message, uint8_t counter,
    uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    uint64_t fields = 0;
    fields = gimbal_insert(fields, 0, 22, gimbal_hold((int32_t)message->roll, -2097152, 2097151));
    fields = gimbal_insert(fields, 22, 22, gimbal_hold((int32_t)message->pitch, -2097152, 2097151));
    fields = gimbal_insert(fields, 44, 4, gimbal_hold((int32_t)message->set, 0, 15));
    gimbal_seal(GIMBAL_BASE_ATTITUDE_DATA_ID, fields, counter, payload);
}

/* From fields whose CRC is right. False, and nothing written, when a field is out of its bounds. */
static inline bool gimbal_base_attitude_read(uint64_t fields, gimbal_base_attitude_t *message)
{
    const int32_t roll = gimbal_extract(fields, 0, 22, true);
    const int32_t pitch = gimbal_extract(fields, 22, 22, true);
    const int32_t set = gimbal_extract(fields, 44, 4, false);
    message->roll = (int32_t)roll;
    message->pitch = (int32_t)pitch;
    message->set = (uint8_t)set;
    return true;
}

/* False, and nothing written, when the CRC or a field is wrong. */
static inline bool gimbal_base_attitude_unpack(const uint8_t payload[GIMBAL_PAYLOAD_SIZE],
    gimbal_base_attitude_t *message)
{
    uint64_t fields;
    if (!gimbal_unseal(GIMBAL_BASE_ATTITUDE_DATA_ID, payload, &fields))
        return false;
    return gimbal_base_attitude_read(fields, message);
}

/* base_rate, device to host:
   angular rate of the base in base axes */
#define GIMBAL_BASE_RATE_ID 0x170u
#define GIMBAL_BASE_RATE_DATA_ID 0x17u
#define GIMBAL_BASE_RATE_PERIOD_TICKS 10u
#define GIMBAL_BASE_RATE_P_STEP 0.0001 /* rad/s */
#define GIMBAL_BASE_RATE_Q_STEP 0.0001 /* rad/s */
#define GIMBAL_BASE_RATE_R_STEP 0.0001 /* rad/s */
#define GIMBAL_BASE_RATE_P_LOW (-32768)
#define GIMBAL_BASE_RATE_P_HIGH 32767
#define GIMBAL_BASE_RATE_Q_LOW (-32768)
#define GIMBAL_BASE_RATE_Q_HIGH 32767
#define GIMBAL_BASE_RATE_R_LOW (-32768)
#define GIMBAL_BASE_RATE_R_HIGH 32767

typedef struct {
    int16_t p; /* base p */
    int16_t q; /* base q */
    int16_t r; /* base r */
} gimbal_base_rate_t;

static inline void gimbal_base_rate_pack(const gimbal_base_rate_t *message, uint8_t counter,
    uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    uint64_t fields = 0;
    fields = gimbal_insert(fields, 0, 16, gimbal_hold((int32_t)message->p, -32768, 32767));
    fields = gimbal_insert(fields, 16, 16, gimbal_hold((int32_t)message->q, -32768, 32767));
    fields = gimbal_insert(fields, 32, 16, gimbal_hold((int32_t)message->r, -32768, 32767));
    gimbal_seal(GIMBAL_BASE_RATE_DATA_ID, fields, counter, payload);
}

/* From fields whose CRC is right. False, and nothing written, when a field is out of its bounds. */
static inline bool gimbal_base_rate_read(uint64_t fields, gimbal_base_rate_t *message)
{
    const int32_t p = gimbal_extract(fields, 0, 16, true);
    const int32_t q = gimbal_extract(fields, 16, 16, true);
    const int32_t r = gimbal_extract(fields, 32, 16, true);
    message->p = (int16_t)p;
    message->q = (int16_t)q;
    message->r = (int16_t)r;
    return true;
}

/* False, and nothing written, when the CRC or a field is wrong. */
static inline bool gimbal_base_rate_unpack(const uint8_t payload[GIMBAL_PAYLOAD_SIZE],
    gimbal_base_rate_t *message)
{
    uint64_t fields;
    if (!gimbal_unseal(GIMBAL_BASE_RATE_DATA_ID, payload, &fields))
        return false;
    return gimbal_base_rate_read(fields, message);
}

/* drive_event, device to host:
   one transition of the drive state machine */
#define GIMBAL_DRIVE_EVENT_ID 0x180u
#define GIMBAL_DRIVE_EVENT_DATA_ID 0x18u
#define GIMBAL_DRIVE_EVENT_PERIOD_TICKS 0u

typedef struct {
    uint8_t from_state; /* state before */
    uint8_t to_state; /* state after */
    uint8_t cause; /* why */
    uint8_t detail; /* more on the cause: axis, limit or request */
    uint16_t tick; /* the device's tick, modulo 4096 */
} gimbal_drive_event_t;

static inline void gimbal_drive_event_pack(const gimbal_drive_event_t *message, uint8_t counter,
    uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    uint64_t fields = 0;
    fields = gimbal_insert(fields, 0, 4, gimbal_hold((int32_t)message->from_state, 0, 7));
    fields = gimbal_insert(fields, 4, 4, gimbal_hold((int32_t)message->to_state, 0, 7));
    fields = gimbal_insert(fields, 8, 6, gimbal_hold((int32_t)message->cause, 0, 13));
    fields = gimbal_insert(fields, 14, 8, gimbal_hold((int32_t)message->detail, 0, 255));
    fields = gimbal_insert(fields, 22, 12, gimbal_hold((int32_t)message->tick, 0, 4095));
    gimbal_seal(GIMBAL_DRIVE_EVENT_DATA_ID, fields, counter, payload);
}

/* From fields whose CRC is right. False, and nothing written, when a field is out of its bounds. */
static inline bool gimbal_drive_event_read(uint64_t fields, gimbal_drive_event_t *message)
{
    const int32_t from_state = gimbal_extract(fields, 0, 4, false);
    const int32_t to_state = gimbal_extract(fields, 4, 4, false);
    const int32_t cause = gimbal_extract(fields, 8, 6, false);
    const int32_t detail = gimbal_extract(fields, 14, 8, false);
    const int32_t tick = gimbal_extract(fields, 22, 12, false);
    if (from_state < 0 || from_state > 7)
        return false;
    if (to_state < 0 || to_state > 7)
        return false;
    if (cause < 0 || cause > 13)
        return false;
    message->from_state = (uint8_t)from_state;
    message->to_state = (uint8_t)to_state;
    message->cause = (uint8_t)cause;
    message->detail = (uint8_t)detail;
    message->tick = (uint16_t)tick;
    return true;
}

/* False, and nothing written, when the CRC or a field is wrong. */
static inline bool gimbal_drive_event_unpack(const uint8_t payload[GIMBAL_PAYLOAD_SIZE],
    gimbal_drive_event_t *message)
{
    uint64_t fields;
    if (!gimbal_unseal(GIMBAL_DRIVE_EVENT_DATA_ID, payload, &fields))
        return false;
    return gimbal_drive_event_read(fields, message);
}

/* base_heading, device to host:
   heading of the base, and when the attitude was true */
#define GIMBAL_BASE_HEADING_ID 0x190u
#define GIMBAL_BASE_HEADING_DATA_ID 0x19u
#define GIMBAL_BASE_HEADING_PERIOD_TICKS 10u
#define GIMBAL_BASE_HEADING_YAW_STEP 2e-06 /* rad */
#define GIMBAL_BASE_HEADING_VALID_FRACTION_STEP 0.00390625 /* tick */
#define GIMBAL_BASE_HEADING_YAW_LOW (-2097152)
#define GIMBAL_BASE_HEADING_YAW_HIGH 2097151

typedef struct {
    int32_t yaw; /* base yaw */
    uint16_t valid_tick; /* the device's tick at which the attitude was true, modulo 4096 */
    uint8_t valid_fraction; /* and how far into that tick */
} gimbal_base_heading_t;

static inline void gimbal_base_heading_pack(const gimbal_base_heading_t *message, uint8_t counter,
    uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    uint64_t fields = 0;
    fields = gimbal_insert(fields, 0, 22, gimbal_hold((int32_t)message->yaw, -2097152, 2097151));
    fields = gimbal_insert(fields, 22, 12, gimbal_hold((int32_t)message->valid_tick, 0, 4095));
    fields = gimbal_insert(fields, 34, 8, gimbal_hold((int32_t)message->valid_fraction, 0, 255));
    gimbal_seal(GIMBAL_BASE_HEADING_DATA_ID, fields, counter, payload);
}

/* From fields whose CRC is right. False, and nothing written, when a field is out of its bounds. */
static inline bool gimbal_base_heading_read(uint64_t fields, gimbal_base_heading_t *message)
{
    const int32_t yaw = gimbal_extract(fields, 0, 22, true);
    const int32_t valid_tick = gimbal_extract(fields, 22, 12, false);
    const int32_t valid_fraction = gimbal_extract(fields, 34, 8, false);
    message->yaw = (int32_t)yaw;
    message->valid_tick = (uint16_t)valid_tick;
    message->valid_fraction = (uint8_t)valid_fraction;
    return true;
}

/* False, and nothing written, when the CRC or a field is wrong. */
static inline bool gimbal_base_heading_unpack(const uint8_t payload[GIMBAL_PAYLOAD_SIZE],
    gimbal_base_heading_t *message)
{
    uint64_t fields;
    if (!gimbal_unseal(GIMBAL_BASE_HEADING_DATA_ID, payload, &fields))
        return false;
    return gimbal_base_heading_read(fields, message);
}

/* base_acceleration, device to host:
   acceleration of the pivot in base axes, of the motion alone: gravity is not in it */
#define GIMBAL_BASE_ACCELERATION_ID 0x1A0u
#define GIMBAL_BASE_ACCELERATION_DATA_ID 0x1Au
#define GIMBAL_BASE_ACCELERATION_PERIOD_TICKS 20u
#define GIMBAL_BASE_ACCELERATION_AX_STEP 0.002 /* m/s^2 */
#define GIMBAL_BASE_ACCELERATION_AY_STEP 0.002 /* m/s^2 */
#define GIMBAL_BASE_ACCELERATION_AZ_STEP 0.002 /* m/s^2 */
#define GIMBAL_BASE_ACCELERATION_AX_LOW (-32768)
#define GIMBAL_BASE_ACCELERATION_AX_HIGH 32767
#define GIMBAL_BASE_ACCELERATION_AY_LOW (-32768)
#define GIMBAL_BASE_ACCELERATION_AY_HIGH 32767
#define GIMBAL_BASE_ACCELERATION_AZ_LOW (-32768)
#define GIMBAL_BASE_ACCELERATION_AZ_HIGH 32767

typedef struct {
    int16_t ax; /* base ax */
    int16_t ay; /* base ay */
    int16_t az; /* base az */
} gimbal_base_acceleration_t;

static inline void gimbal_base_acceleration_pack(const gimbal_base_acceleration_t *message, uint8_t counter,
    uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    uint64_t fields = 0;
    fields = gimbal_insert(fields, 0, 16, gimbal_hold((int32_t)message->ax, -32768, 32767));
    fields = gimbal_insert(fields, 16, 16, gimbal_hold((int32_t)message->ay, -32768, 32767));
    fields = gimbal_insert(fields, 32, 16, gimbal_hold((int32_t)message->az, -32768, 32767));
    gimbal_seal(GIMBAL_BASE_ACCELERATION_DATA_ID, fields, counter, payload);
}

/* From fields whose CRC is right. False, and nothing written, when a field is out of its bounds. */
static inline bool gimbal_base_acceleration_read(uint64_t fields, gimbal_base_acceleration_t *message)
{
    const int32_t ax = gimbal_extract(fields, 0, 16, true);
    const int32_t ay = gimbal_extract(fields, 16, 16, true);
    const int32_t az = gimbal_extract(fields, 32, 16, true);
    message->ax = (int16_t)ax;
    message->ay = (int16_t)ay;
    message->az = (int16_t)az;
    return true;
}

/* False, and nothing written, when the CRC or a field is wrong. */
static inline bool gimbal_base_acceleration_unpack(const uint8_t payload[GIMBAL_PAYLOAD_SIZE],
    gimbal_base_acceleration_t *message)
{
    uint64_t fields;
    if (!gimbal_unseal(GIMBAL_BASE_ACCELERATION_DATA_ID, payload, &fields))
        return false;
    return gimbal_base_acceleration_read(fields, message);
}

/* identity, device to host:
   who the antenna is; at once when asked. Without it and identity_unit no torque is switched on */
#define GIMBAL_IDENTITY_ID 0x1B0u
#define GIMBAL_IDENTITY_DATA_ID 0x1Bu
#define GIMBAL_IDENTITY_PERIOD_TICKS 1000u

typedef struct {
    uint8_t protocol_version; /* version of this protocol */
    uint32_t name; /* CRC-32 of the antenna's name in UTF-8, its lower 31 bits */
    bool has_brake_outer; /* the outer axis has a holding brake */
    bool has_brake_inner; /* the inner axis has a holding brake */
} gimbal_identity_t;

static inline void gimbal_identity_pack(const gimbal_identity_t *message, uint8_t counter,
    uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    uint64_t fields = 0;
    fields = gimbal_insert(fields, 0, 8, gimbal_hold((int32_t)message->protocol_version, 0, 255));
    fields = gimbal_insert(fields, 8, 31, gimbal_hold((int32_t)message->name, 0, 2147483647));
    fields = gimbal_insert(fields, 39, 1, (int32_t)message->has_brake_outer);
    fields = gimbal_insert(fields, 40, 1, (int32_t)message->has_brake_inner);
    gimbal_seal(GIMBAL_IDENTITY_DATA_ID, fields, counter, payload);
}

/* From fields whose CRC is right. False, and nothing written, when a field is out of its bounds. */
static inline bool gimbal_identity_read(uint64_t fields, gimbal_identity_t *message)
{
    const int32_t protocol_version = gimbal_extract(fields, 0, 8, false);
    const int32_t name = gimbal_extract(fields, 8, 31, false);
    const int32_t has_brake_outer = gimbal_extract(fields, 39, 1, false);
    const int32_t has_brake_inner = gimbal_extract(fields, 40, 1, false);
    message->protocol_version = (uint8_t)protocol_version;
    message->name = (uint32_t)name;
    message->has_brake_outer = has_brake_outer != 0;
    message->has_brake_inner = has_brake_inner != 0;
    return true;
}

/* False, and nothing written, when the CRC or a field is wrong. */
static inline bool gimbal_identity_unpack(const uint8_t payload[GIMBAL_PAYLOAD_SIZE],
    gimbal_identity_t *message)
{
    uint64_t fields;
    if (!gimbal_unseal(GIMBAL_IDENTITY_DATA_ID, payload, &fields))
        return false;
    return gimbal_identity_read(fields, message);
}

/* identity_unit, device to host:
   which antenna of its kind it is, and what a unit of its torques is */
#define GIMBAL_IDENTITY_UNIT_ID 0x1C0u
#define GIMBAL_IDENTITY_UNIT_DATA_ID 0x1Cu
#define GIMBAL_IDENTITY_UNIT_PERIOD_TICKS 1000u

typedef struct {
    uint32_t serial_number; /* serial number */
    uint8_t torque_exponent_outer; /* a torque of the outer axis counts its step times two to this */
    uint8_t torque_exponent_inner; /* a torque of the inner axis counts its step times two to this */
} gimbal_identity_unit_t;

static inline void gimbal_identity_unit_pack(const gimbal_identity_unit_t *message, uint8_t counter,
    uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    uint64_t fields = 0;
    fields = gimbal_insert(fields, 0, 31, gimbal_hold((int32_t)message->serial_number, 0, 2147483647));
    fields = gimbal_insert(fields, 31, 5, gimbal_hold((int32_t)message->torque_exponent_outer, 0, 31));
    fields = gimbal_insert(fields, 36, 5, gimbal_hold((int32_t)message->torque_exponent_inner, 0, 31));
    gimbal_seal(GIMBAL_IDENTITY_UNIT_DATA_ID, fields, counter, payload);
}

/* From fields whose CRC is right. False, and nothing written, when a field is out of its bounds. */
static inline bool gimbal_identity_unit_read(uint64_t fields, gimbal_identity_unit_t *message)
{
    const int32_t serial_number = gimbal_extract(fields, 0, 31, false);
    const int32_t torque_exponent_outer = gimbal_extract(fields, 31, 5, false);
    const int32_t torque_exponent_inner = gimbal_extract(fields, 36, 5, false);
    message->serial_number = (uint32_t)serial_number;
    message->torque_exponent_outer = (uint8_t)torque_exponent_outer;
    message->torque_exponent_inner = (uint8_t)torque_exponent_inner;
    return true;
}

/* False, and nothing written, when the CRC or a field is wrong. */
static inline bool gimbal_identity_unit_unpack(const uint8_t payload[GIMBAL_PAYLOAD_SIZE],
    gimbal_identity_unit_t *message)
{
    uint64_t fields;
    if (!gimbal_unseal(GIMBAL_IDENTITY_UNIT_DATA_ID, payload, &fields))
        return false;
    return gimbal_identity_unit_read(fields, message);
}

#ifdef __cplusplus
}
#endif

#endif /* GIMBAL_PROTOCOL_H */
