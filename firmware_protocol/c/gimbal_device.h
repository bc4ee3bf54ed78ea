/* The antenna's side of the wire: drive states, deadman, limits, stops, frames. C11, no heap, no operating system, whole
 * numbers only; everything has a fixed size.
 *
 * Call `gimbal_device_start` once, `gimbal_device_receive` for each frame that comes, `gimbal_device_tick` once a tick.
 * What touches the electronics is in `gimbal_hardware_t`: functions that you write.
 *
 * Numbers are raw integers of the wire (gimbal_protocol.h has the steps): torque counts 0.000125 N m times two to the
 * axis' exponent, position 2 pi / 2^22 rad, rate 0.00001 rad/s, time ticks. A fraction is a whole number of 1 / 2^16.
 */
#ifndef GIMBAL_DEVICE_H
#define GIMBAL_DEVICE_H

#include <stddef.h>

#include "gimbal_protocol.h"

#ifdef __cplusplus
extern "C" {
#endif

#define GIMBAL_AXES 2
#define GIMBAL_SCALE_BITS 16
/* `last_sequence` before the first set-point */
#define GIMBAL_NO_SEQUENCE (-1)

/* What the drive does beyond a travel limit; torque that leads further out is cut in any case. */
enum gimbal_travel_reaction { GIMBAL_TRAVEL_CUT_TORQUE = 0, GIMBAL_TRAVEL_FAULT = 1 };

/* Settings of one axis: constant, may stand in flash. */
typedef struct {
    int32_t has_brake;
    int32_t exponent;        /* of two, by which a raw torque counts more */
    int32_t torque_limit;
    int32_t travel_low;      /* INT32_MIN and INT32_MAX without limits */
    int32_t travel_high;
    int32_t rate_limit;      /* joint rate beyond which torque that drives on is cut */
    int32_t overspeed;       /* rate that is a fault */
    int32_t max_winding;
    int64_t stop_rate_gain;  /* torque per rate, per count, and per count and tick (fractions) */
    int64_t stop_position_gain;
    int64_t stop_integral_gain;
    int32_t stop_rate_per_tick;
    int64_t impulse_of_rate; /* torque times ticks for a rate of one (fraction) */
    int64_t strange_impulse; /* most impulse that is not the motor's (fraction), 0 for no guard */
} gimbal_axis_settings_t;

/* Settings of the drive: constant, may stand in flash. */
typedef struct {
    int32_t axes; /* 1 or 2; the fields of an axis that is not there stay zero */
    int32_t startup_ticks;
    int32_t control_silence_ticks; /* 0 switches this guard off */
    int32_t travel_reaction;
    int32_t fault_reaction;
    int32_t min_supply;
    int32_t rest_rate;
    int32_t rest_ticks;
    int32_t hold_ticks;
    int32_t reaction_ticks;
    int64_t rate_of_count; /* raw rate of one count a tick (fraction) */
    int64_t count_of_rate; /* counts a tick of a raw rate of one (fraction) */
    int32_t brake_ticks;   /* that a holding brake takes to close */
    int32_t name_code;     /* CRC-32 of the antenna's name, lower 31 bits */
    int32_t serial_number;
    int32_t max_disagreement;
    int32_t stop_disagreement;
    int64_t momentum_kept; /* share of momentum remembered from tick to tick (fraction) */
    int32_t deadman_window; /* until the host sends its own */
    int32_t deadman_reaction;
    gimbal_axis_settings_t joints[GIMBAL_AXES];
} gimbal_settings_t;

/* What the drive keeps of one axis. */
typedef struct {
    int32_t set_torque; /* last set-point */
    int32_t set_enable;
    int32_t applied_torque; /* what is asked of the current loop */
    int32_t encoder;        /* as sampled */
    int32_t gyro;
    int64_t joint_rate; /* low-passed difference of the encoder */
    int32_t winding;
    int32_t sensor_fault;
    int64_t stop_rate; /* stopping reference, and how far ahead of the joint it is (fraction of a count) */
    int64_t stop_lead;
    int64_t stop_integral;
    int32_t stop_encoder; /* when the reference was last advanced */
    int32_t brake_command;
    int32_t brake_state;
    int32_t brake_age;
    int32_t shorted;
    int64_t momentum; /* of the runaway guard */
    int64_t effort;
    int64_t peak_torque;
    int32_t ran_away;
    int32_t motor_torque; /* measured, for motor_status */
} gimbal_joint_t;

/* What the drive keeps. */
typedef struct {
    int32_t state;
    int32_t state_age;
    int32_t fault;
    int32_t fault_detail;
    uint32_t tick;
    int32_t last_sequence;
    int32_t margin;
    uint32_t taken;
    uint32_t refused;
    int32_t window;
    int32_t reaction;
    int32_t active_reaction;
    int32_t reset_level;
    int32_t control_age;
    int32_t travel_cleared;
    int32_t rest_count;
    int32_t limits;
    int32_t supply;
    int32_t yaw;
    int32_t attitude_tick;
    gimbal_joint_t joints[GIMBAL_AXES];
} gimbal_drive_t;

/* What is wanted of an axis in this tick. */
typedef struct {
    int32_t torque;  /* raw; 0 while the power stage is off */
    bool powered;    /* whether the power stage makes current */
    bool shorted;    /* whether the winding is shorted */
    bool brake_held; /* whether the holding brake has no current, and so holds */
} gimbal_actuation_t;

/* What the sensors of an axis say at the end of a tick. */
typedef struct {
    int32_t position;
    int32_t rate;
    int32_t torque;  /* measured, from motor current */
    int32_t winding; /* temperature, 0.1 degC */
    bool valid;      /* false when they could not be read */
} gimbal_sample_t;

/* Motion of the base, as `base_attitude`, `base_heading`, `base_rate` and `base_acceleration` carry it. */
typedef struct {
    int32_t roll, pitch, yaw;
    int32_t p, q, r;
    int32_t ax, ay, az;
} gimbal_base_t;

/* The electronics. Every function gets `context`; none may wait. */
typedef struct {
    void *context;
    /* supply voltage, raw, at the start of a tick */
    int32_t (*supply)(void *context);
    /* make it so until the next call; then let the tick pass */
    void (*actuate)(void *context, int axis, const gimbal_actuation_t *wanted);
    /* the sensors of an axis, at the end of the tick */
    void (*sample)(void *context, int axis, gimbal_sample_t *sampled);
    /* the base at the end of the tick; NULL without an inertial navigation: then nothing is sent of it */
    void (*base)(void *context, gimbal_base_t *base);
    /* one frame to the host */
    void (*send)(void *context, uint16_t id, const uint8_t payload[GIMBAL_PAYLOAD_SIZE]);
} gimbal_hardware_t;

/* Messages that a host sends, as places of `receivers` and `fresh`. */
enum gimbal_heard { GIMBAL_HEARD_DRIVE_CONTROL, GIMBAL_HEARD_SET_POINT, GIMBAL_HEARD_DEADMAN_CONFIG, GIMBAL_HEARD_COUNT };

/* Receiver of one message. */
typedef struct {
    int32_t last_counter; /* -1 takes the next frame whatever its counter */
    uint32_t ticks_since_good;
    uint32_t good;
    uint32_t crc_errors;
    uint32_t out_of_range;
    uint32_t duplicates;
    uint32_t lost_frames;
} gimbal_receiver_t;

/* Messages that a device sends, as places of `counters`. */
enum gimbal_said {
    GIMBAL_SAID_FEEDBACK_OUTER,
    GIMBAL_SAID_FEEDBACK_INNER,
    GIMBAL_SAID_DRIVE_STATUS,
    GIMBAL_SAID_MOTOR_STATUS_OUTER,
    GIMBAL_SAID_MOTOR_STATUS_INNER,
    GIMBAL_SAID_BASE_ATTITUDE,
    GIMBAL_SAID_BASE_RATE,
    GIMBAL_SAID_DRIVE_EVENT,
    GIMBAL_SAID_BASE_HEADING,
    GIMBAL_SAID_BASE_ACCELERATION,
    GIMBAL_SAID_IDENTITY,
    GIMBAL_SAID_IDENTITY_UNIT,
    GIMBAL_SAID_COUNT
};

/* One device. Its memory is the caller's; nothing of it is for him to write. */
typedef struct {
    const gimbal_settings_t *settings;
    const gimbal_hardware_t *hardware;
    gimbal_drive_t drive;
    bool fresh[GIMBAL_HEARD_COUNT];
    gimbal_drive_control_t control;
    gimbal_set_point_t set_point;
    gimbal_deadman_config_t deadman;
    bool has_event;
    gimbal_drive_event_t event;
    gimbal_receiver_t receivers[GIMBAL_HEARD_COUNT];
    uint32_t stray_frames;
    uint8_t counters[GIMBAL_SAID_COUNT];
} gimbal_device_t;

/* A drive that has just got its supply. Settings and hardware must outlive it. */
void gimbal_device_start(gimbal_device_t *device, const gimbal_settings_t *settings, const gimbal_hardware_t *hardware);

/* Before the frames of a tick: what was fresh in the last one is not any more, and receivers age. */
void gimbal_device_begin(gimbal_device_t *device);

/* One frame that has come, whatever is in it; true when it was taken. */
bool gimbal_device_receive(gimbal_device_t *device, uint16_t id, const uint8_t payload[GIMBAL_PAYLOAD_SIZE]);

/* One tick: decide, actuate, sample, send. */
void gimbal_device_tick(gimbal_device_t *device);

#ifdef __cplusplus
}
#endif

#endif /* GIMBAL_DEVICE_H */
