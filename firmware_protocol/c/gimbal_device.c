/* One tick of the device: frames in, decision, electronics, sensors, frames out. */
#include "gimbal_parts.h"

/* The joint rate takes over one part in four of each new difference. */
#define JOINT_RATE_SHARE 4
#define TICK_MASK 4095u
#define MOTOR_PHASE 3u
#define ATTITUDE_PHASE 0u
#define HEADING_PHASE 1u
#define ACCELERATION_PHASE 7u
#define IDENTITY_PHASE 2u
#define UNIT_PHASE 4u

void gimbal_device_start(gimbal_device_t *device, const gimbal_settings_t *settings, const gimbal_hardware_t *hardware)
{
    static const gimbal_device_t nothing = {0};
    *device = nothing;
    device->settings = settings;
    device->hardware = hardware;
    device->drive.last_sequence = GIMBAL_NO_SEQUENCE;
    device->drive.window = settings->deadman_window;
    device->drive.reaction = settings->deadman_reaction;
    /* an edge needs a level that was seen low before */
    device->drive.reset_level = 1;
    for (int axis = 0; axis < GIMBAL_AXES; ++axis) {
        if (settings->joints[axis].has_brake == 1) {
            /* a brake holds without power: it is closed when the drive wakes up */
            device->drive.joints[axis].brake_state = GIMBAL_BRAKE_STATE_RELEASED;
            device->drive.joints[axis].brake_age = settings->brake_ticks;
        }
    }
    for (int message = 0; message < GIMBAL_HEARD_COUNT; ++message)
        device->receivers[message].last_counter = GIMBAL_UNKNOWN_COUNTER;
}

void gimbal_device_begin(gimbal_device_t *device)
{
    static const uint32_t period[GIMBAL_HEARD_COUNT] = {
        GIMBAL_DRIVE_CONTROL_PERIOD_TICKS, GIMBAL_SET_POINT_PERIOD_TICKS, GIMBAL_DEADMAN_CONFIG_PERIOD_TICKS};
    for (int message = 0; message < GIMBAL_HEARD_COUNT; ++message) {
        gimbal_receiver_t *receiver = &device->receivers[message];
        const uint32_t memory = period[message] > 0u ? GIMBAL_LOST_PERIODS * period[message] : GIMBAL_EVENT_MEMORY_TICKS;
        device->fresh[message] = false;
        if (receiver->ticks_since_good <= memory)
            receiver->ticks_since_good += 1u;
        if (receiver->ticks_since_good > memory)
            receiver->last_counter = GIMBAL_UNKNOWN_COUNTER;
    }
}

/* Whether a counter is new; counts frames that are missing before it. */
static bool is_new(gimbal_receiver_t *receiver, uint8_t counter, uint32_t *lost)
{
    *lost = 0u;
    if (receiver->last_counter == GIMBAL_UNKNOWN_COUNTER)
        return true;
    const uint32_t step = ((uint32_t)counter - (uint32_t)receiver->last_counter) & 15u;
    if (step == 0u || step >= GIMBAL_LATE_STEP)
        return false;
    *lost = step - 1u;
    return true;
}

static bool read_fields(gimbal_device_t *device, int message, uint64_t fields)
{
    switch (message) {
    case GIMBAL_HEARD_DRIVE_CONTROL:
        return gimbal_drive_control_read(fields, &device->control);
    case GIMBAL_HEARD_SET_POINT:
        return gimbal_set_point_read(fields, &device->set_point);
    default:
        return gimbal_deadman_config_read(fields, &device->deadman);
    }
}

bool gimbal_device_receive(gimbal_device_t *device, uint16_t id, const uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    int message;
    uint8_t data_id;
    switch (id) {
    case GIMBAL_DRIVE_CONTROL_ID:
        message = GIMBAL_HEARD_DRIVE_CONTROL;
        data_id = GIMBAL_DRIVE_CONTROL_DATA_ID;
        break;
    case GIMBAL_SET_POINT_ID:
        message = GIMBAL_HEARD_SET_POINT;
        data_id = GIMBAL_SET_POINT_DATA_ID;
        break;
    case GIMBAL_DEADMAN_CONFIG_ID:
        message = GIMBAL_HEARD_DEADMAN_CONFIG;
        data_id = GIMBAL_DEADMAN_CONFIG_DATA_ID;
        break;
    default:
        device->stray_frames += 1u;
        return false;
    }
    gimbal_receiver_t *receiver = &device->receivers[message];
    uint64_t fields = 0u;
    uint32_t lost = 0u;
    if (!gimbal_unseal(data_id, payload, &fields)) {
        receiver->crc_errors += 1u;
        return false;
    }
    const uint8_t counter = gimbal_alive_counter(payload);
    if (!is_new(receiver, counter, &lost)) {
        receiver->duplicates += 1u;
        return false;
    }
    if (!read_fields(device, message, fields)) {
        receiver->out_of_range += 1u;
        return false;
    }
    receiver->last_counter = counter;
    receiver->ticks_since_good = 0u;
    receiver->good += 1u;
    receiver->lost_frames += lost;
    device->fresh[message] = true;
    return true;
}

/* Torque of each axis for this tick: the set-point, the drive's own stop, or nothing. Other states know no torque. */
static void command_torque(gimbal_device_t *device)
{
    const gimbal_settings_t *settings = device->settings;
    gimbal_drive_t *drive = &device->drive;
    drive->limits = 0;
    for (int axis = 0; axis < settings->axes; ++axis) {
        gimbal_joint_t *joint = &drive->joints[axis];
        int64_t torque = 0;
        if (drive->state == GIMBAL_DRIVE_STATE_OPERATION_ENABLED) {
            if (joint->set_enable == 1)
                torque = gimbal_without_outward(&settings->joints[axis], joint, joint->set_torque);
        } else if (gimbal_stops_by_itself(drive)) {
            torque = gimbal_stop_torque(settings, drive, axis);
        }
        joint->applied_torque = gimbal_within_torque_limit(settings, drive, axis, torque);
    }
}

static void actuate(gimbal_device_t *device)
{
    const gimbal_drive_t *drive = &device->drive;
    /* the power stage makes no current while the winding is shorted or the axis coasts */
    const bool by_torque = gimbal_stop_in_force(device->settings, drive) > GIMBAL_STOP_REACTION_BRAKE;
    const bool powered =
        drive->state == GIMBAL_DRIVE_STATE_OPERATION_ENABLED || (gimbal_stops_by_itself(drive) && by_torque);
    for (int axis = 0; axis < device->settings->axes; ++axis) {
        const gimbal_joint_t *joint = &drive->joints[axis];
        const gimbal_actuation_t wanted = {
            .torque = joint->applied_torque,
            .powered = powered,
            .shorted = joint->shorted == 1,
            .brake_held = joint->brake_state == GIMBAL_BRAKE_STATE_ENGAGED,
        };
        device->hardware->actuate(device->hardware->context, axis, &wanted);
    }
}

/* A number at the end of its range says nothing any more. */
static int32_t sensor_fault(int32_t position, int32_t rate)
{
    if (position <= GIMBAL_FEEDBACK_OUTER_POSITION_LOW || position >= GIMBAL_FEEDBACK_OUTER_POSITION_HIGH)
        return GIMBAL_FAULT_CODE_ENCODER;
    if (rate <= GIMBAL_FEEDBACK_OUTER_RATE_LOW || rate >= GIMBAL_FEEDBACK_OUTER_RATE_HIGH)
        return GIMBAL_FAULT_CODE_GYRO;
    return GIMBAL_FAULT_CODE_NONE;
}

static void sample(gimbal_device_t *device)
{
    const gimbal_settings_t *settings = device->settings;
    gimbal_drive_t *drive = &device->drive;
    for (int axis = 0; axis < settings->axes; ++axis) {
        gimbal_joint_t *joint = &drive->joints[axis];
        gimbal_sample_t now = {0};
        device->hardware->sample(device->hardware->context, axis, &now);
        joint->motor_torque = now.torque;
        if (!now.valid) {
            joint->sensor_fault = GIMBAL_FAULT_CODE_INTERNAL;
            continue;
        }
        const int32_t position =
            gimbal_hold(now.position, GIMBAL_FEEDBACK_OUTER_POSITION_LOW, GIMBAL_FEEDBACK_OUTER_POSITION_HIGH);
        const int32_t rate = gimbal_hold(now.rate, GIMBAL_FEEDBACK_OUTER_RATE_LOW, GIMBAL_FEEDBACK_OUTER_RATE_HIGH);
        /* the first sample after power-up has none before it */
        const int64_t step = drive->tick > 1u ? (int64_t)position - joint->encoder : 0;
        const int64_t moved = gimbal_floor_scaled(step * settings->rate_of_count);
        const int64_t behind = moved - joint->joint_rate;
        joint->joint_rate += behind >= 0 ? behind / JOINT_RATE_SHARE : -((-behind + JOINT_RATE_SHARE - 1) / JOINT_RATE_SHARE);
        const int32_t gyro_before = joint->gyro;
        joint->encoder = position;
        joint->gyro = rate;
        gimbal_watch_momentum(settings, drive, axis, gyro_before);
        joint->winding = now.winding;
        joint->sensor_fault = sensor_fault(position, rate);
    }
}

static uint8_t next_counter(gimbal_device_t *device, int message)
{
    const uint8_t counter = device->counters[message];
    device->counters[message] = (uint8_t)((counter + 1u) & 15u);
    return counter;
}

static void send(const gimbal_device_t *device, uint16_t id, const uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    device->hardware->send(device->hardware->context, id, payload);
}

static void report_motor(gimbal_device_t *device, int axis)
{
    const gimbal_joint_t *joint = &device->drive.joints[axis];
    const bool is_there = axis < device->settings->axes;
    uint8_t payload[GIMBAL_PAYLOAD_SIZE];
    if (axis == 0) {
        const gimbal_motor_status_outer_t outer = {
            .torque = joint->motor_torque,
            .temperature = (int16_t)joint->winding,
            .supply = (uint16_t)device->drive.supply,
            .brake = (uint8_t)joint->brake_state,
            .shorted = joint->shorted == 1,
        };
        gimbal_motor_status_outer_pack(&outer, next_counter(device, GIMBAL_SAID_MOTOR_STATUS_OUTER), payload);
        send(device, GIMBAL_MOTOR_STATUS_OUTER_ID, payload);
    } else {
        gimbal_motor_status_inner_t inner = {0};
        if (is_there) {
            inner.torque = joint->motor_torque;
            inner.temperature = (int16_t)joint->winding;
            inner.supply = (uint16_t)device->drive.supply;
            inner.brake = (uint8_t)joint->brake_state;
            inner.shorted = joint->shorted == 1;
        }
        gimbal_motor_status_inner_pack(&inner, next_counter(device, GIMBAL_SAID_MOTOR_STATUS_INNER), payload);
        send(device, GIMBAL_MOTOR_STATUS_INNER_ID, payload);
    }
}

/* What the base's inertial navigation says at this tick, at most one message. */
static void report_base(gimbal_device_t *device)
{
    gimbal_drive_t *drive = &device->drive;
    const uint32_t phase = drive->tick % GIMBAL_BASE_ATTITUDE_PERIOD_TICKS;
    uint8_t payload[GIMBAL_PAYLOAD_SIZE];
    gimbal_base_t base = {0};
    if (device->hardware->base == NULL)
        return;
    if (phase == HEADING_PHASE) {
        const gimbal_base_heading_t heading = {.yaw = drive->yaw, .valid_tick = (uint16_t)drive->attitude_tick};
        gimbal_base_heading_pack(&heading, next_counter(device, GIMBAL_SAID_BASE_HEADING), payload);
        send(device, GIMBAL_BASE_HEADING_ID, payload);
        return;
    }
    const bool accelerated = drive->tick % GIMBAL_BASE_ACCELERATION_PERIOD_TICKS == ACCELERATION_PHASE;
    if (phase != ATTITUDE_PHASE && phase != GIMBAL_BASE_ATTITUDE_PERIOD_TICKS / 2u && !accelerated)
        return;
    device->hardware->base(device->hardware->context, &base);
    if (phase == ATTITUDE_PHASE) {
        const gimbal_base_attitude_t attitude = {
            .roll = base.roll, .pitch = base.pitch, .set = (uint8_t)(drive->tick & 15u)};
        /* kept for the heading, which goes out with the next tick */
        drive->yaw = base.yaw;
        drive->attitude_tick = (int32_t)(drive->tick & TICK_MASK);
        gimbal_base_attitude_pack(&attitude, next_counter(device, GIMBAL_SAID_BASE_ATTITUDE), payload);
        send(device, GIMBAL_BASE_ATTITUDE_ID, payload);
    } else if (phase == GIMBAL_BASE_ATTITUDE_PERIOD_TICKS / 2u) {
        const gimbal_base_rate_t rate = {.p = (int16_t)base.p, .q = (int16_t)base.q, .r = (int16_t)base.r};
        gimbal_base_rate_pack(&rate, next_counter(device, GIMBAL_SAID_BASE_RATE), payload);
        send(device, GIMBAL_BASE_RATE_ID, payload);
    } else {
        const gimbal_base_acceleration_t acceleration = {
            .ax = (int16_t)base.ax, .ay = (int16_t)base.ay, .az = (int16_t)base.az};
        gimbal_base_acceleration_pack(&acceleration, next_counter(device, GIMBAL_SAID_BASE_ACCELERATION), payload);
        send(device, GIMBAL_BASE_ACCELERATION_ID, payload);
    }
}

static void report_identity(gimbal_device_t *device, bool asked)
{
    const gimbal_settings_t *settings = device->settings;
    const uint32_t phase = device->drive.tick % GIMBAL_IDENTITY_PERIOD_TICKS;
    uint8_t payload[GIMBAL_PAYLOAD_SIZE];
    if (asked || phase == IDENTITY_PHASE) {
        const gimbal_identity_t who = {
            .protocol_version = GIMBAL_PROTOCOL_VERSION,
            .name = (uint32_t)settings->name_code,
            .has_brake_outer = settings->joints[0].has_brake == 1,
            .has_brake_inner = settings->joints[1].has_brake == 1,
        };
        gimbal_identity_pack(&who, next_counter(device, GIMBAL_SAID_IDENTITY), payload);
        send(device, GIMBAL_IDENTITY_ID, payload);
    }
    if (asked || phase == UNIT_PHASE) {
        const gimbal_identity_unit_t unit = {
            .serial_number = (uint32_t)settings->serial_number,
            .torque_exponent_outer = (uint8_t)settings->joints[0].exponent,
            .torque_exponent_inner = (uint8_t)settings->joints[1].exponent,
        };
        gimbal_identity_unit_pack(&unit, next_counter(device, GIMBAL_SAID_IDENTITY_UNIT), payload);
        send(device, GIMBAL_IDENTITY_UNIT_ID, payload);
    }
}

/* Feedback of both axes, and the status, which closes the set of the tick. */
static void report_set(gimbal_device_t *device)
{
    const gimbal_drive_t *drive = &device->drive;
    uint8_t payload[GIMBAL_PAYLOAD_SIZE];
    const gimbal_feedback_outer_t outer = {.position = drive->joints[0].encoder, .rate = drive->joints[0].gyro};
    gimbal_feedback_outer_pack(&outer, next_counter(device, GIMBAL_SAID_FEEDBACK_OUTER), payload);
    send(device, GIMBAL_FEEDBACK_OUTER_ID, payload);
    const gimbal_feedback_inner_t inner = {.position = drive->joints[1].encoder, .rate = drive->joints[1].gyro};
    gimbal_feedback_inner_pack(&inner, next_counter(device, GIMBAL_SAID_FEEDBACK_INNER), payload);
    send(device, GIMBAL_FEEDBACK_INNER_ID, payload);
    const gimbal_drive_status_t status = {
        .state = (uint8_t)drive->state,
        .fault = (uint8_t)drive->fault,
        .last_sequence = (uint16_t)((uint32_t)drive->last_sequence & 1023u),
        .deadman_margin = (uint8_t)drive->margin,
        .limits = (uint8_t)drive->limits,
        .tick = (uint16_t)(drive->tick & TICK_MASK),
    };
    gimbal_drive_status_pack(&status, next_counter(device, GIMBAL_SAID_DRIVE_STATUS), payload);
    send(device, GIMBAL_DRIVE_STATUS_ID, payload);
}

static void report(gimbal_device_t *device)
{
    const uint32_t motor_phase = device->drive.tick % GIMBAL_MOTOR_STATUS_OUTER_PERIOD_TICKS;
    if (device->has_event) {
        uint8_t payload[GIMBAL_PAYLOAD_SIZE];
        gimbal_drive_event_pack(&device->event, next_counter(device, GIMBAL_SAID_DRIVE_EVENT), payload);
        send(device, GIMBAL_DRIVE_EVENT_ID, payload);
    }
    if (motor_phase == MOTOR_PHASE)
        report_motor(device, 0);
    else if (motor_phase == MOTOR_PHASE + GIMBAL_MOTOR_STATUS_OUTER_PERIOD_TICKS / 2u)
        report_motor(device, 1);
    report_base(device);
    report_identity(device, device->fresh[GIMBAL_HEARD_DRIVE_CONTROL] && device->control.identify);
    report_set(device);
}

void gimbal_device_tick(gimbal_device_t *device)
{
    device->has_event = false;
    device->drive.tick += 1u;
    device->drive.supply = device->hardware->supply(device->hardware->context);
    gimbal_take_set_point(device);
    gimbal_take_deadman_config(device);
    gimbal_take_brake_commands(device);
    gimbal_step_state(device);
    command_torque(device);
    gimbal_hold_axes(device->settings, &device->drive);
    actuate(device);
    sample(device);
    gimbal_flag_travel_and_rate(device->settings, &device->drive);
    report(device);
}
