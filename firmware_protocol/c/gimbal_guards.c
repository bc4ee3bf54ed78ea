/* The drive's guards: what makes a fault at this tick, and what the limits leave of a torque. */
#include "gimbal_parts.h"

/* ticks that a torque may act late */
#define LATE_TICKS 3

static gimbal_finding_t found(int32_t fault, int32_t about)
{
    const gimbal_finding_t finding = {fault, about};
    return finding;
}

static gimbal_finding_t fault_of_power(const gimbal_settings_t *settings, const gimbal_drive_t *drive)
{
    for (int axis = 0; axis < settings->axes; ++axis) {
        if (drive->joints[axis].winding > settings->joints[axis].max_winding)
            return found(GIMBAL_FAULT_CODE_OVERTEMPERATURE, axis);
    }
    /* below SWITCHED_ON the power stage needs no supply */
    if (drive->supply < settings->min_supply && drive->state >= GIMBAL_DRIVE_STATE_SWITCHED_ON)
        return found(GIMBAL_FAULT_CODE_UNDERVOLTAGE, 0);
    return found(GIMBAL_FAULT_CODE_NONE, 0);
}

static gimbal_finding_t fault_of_hardware(const gimbal_settings_t *settings, const gimbal_drive_t *drive)
{
    for (int axis = 0; axis < settings->axes; ++axis) {
        const int32_t fault = drive->joints[axis].sensor_fault;
        if (fault != GIMBAL_FAULT_CODE_NONE)
            return found(fault, axis);
    }
    return fault_of_power(settings, drive);
}

/* 1 beyond the upper travel limit, -1 beyond the lower one, 0 between them */
static int beyond_travel(const gimbal_axis_settings_t *own, const gimbal_joint_t *joint)
{
    if (joint->encoder >= own->travel_high)
        return 1;
    return joint->encoder <= own->travel_low ? -1 : 0;
}

/* Fault that holds now and its axis; sensors and temperature count in every state, the rest with power on. */
gimbal_finding_t gimbal_find_fault(const gimbal_settings_t *settings, const gimbal_drive_t *drive)
{
    const gimbal_finding_t hardware = fault_of_hardware(settings, drive);
    if (hardware.fault != GIMBAL_FAULT_CODE_NONE || !gimbal_has_power(drive->state))
        return hardware;
    for (int axis = 0; axis < settings->axes; ++axis) {
        const gimbal_joint_t *joint = &drive->joints[axis];
        const int64_t by_joint = gimbal_abs(joint->joint_rate);
        const int64_t by_gyro = gimbal_abs(joint->gyro);
        if (by_joint > settings->joints[axis].overspeed || by_gyro > settings->joints[axis].overspeed)
            return found(GIMBAL_FAULT_CODE_OVERSPEED, axis);
    }
    for (int axis = 0; axis < settings->axes; ++axis) {
        if (gimbal_disagreement(&drive->joints[axis]) > settings->max_disagreement)
            return found(GIMBAL_FAULT_CODE_SENSORS_DISAGREE, axis);
    }
    for (int axis = 0; axis < settings->axes; ++axis) {
        if (drive->joints[axis].ran_away == 1)
            return found(GIMBAL_FAULT_CODE_RUNAWAY, axis);
    }
    for (int axis = 0; axis < settings->axes; ++axis) {
        if (settings->travel_reaction == GIMBAL_TRAVEL_FAULT && drive->travel_cleared == 0
            && beyond_travel(&settings->joints[axis], &drive->joints[axis]) != 0)
            return found(GIMBAL_FAULT_CODE_TRAVEL_LIMIT, axis);
    }
    if (drive->margin == 0)
        return found(GIMBAL_FAULT_CODE_DEADMAN, 0);
    if (settings->control_silence_ticks > 0 && drive->control_age > settings->control_silence_ticks)
        return found(GIMBAL_FAULT_CODE_COMMUNICATION, 0);
    return found(GIMBAL_FAULT_CODE_NONE, 0);
}

/* By how much encoder and gyro differ on an axis' rate; the gyro sees the base turn too. */
int64_t gimbal_disagreement(const gimbal_joint_t *joint)
{
    return gimbal_abs(joint->joint_rate - joint->gyro);
}

/* Whether a stop may use torque: not without supply or with a hot winding. */
bool gimbal_supply_serves(const gimbal_settings_t *settings, const gimbal_drive_t *drive)
{
    return fault_of_power(settings, drive).fault == GIMBAL_FAULT_CODE_NONE;
}

bool gimbal_beyond_any_travel(const gimbal_settings_t *settings, const gimbal_drive_t *drive)
{
    bool beyond = false;
    for (int axis = 0; axis < settings->axes; ++axis)
        beyond = beyond || beyond_travel(&settings->joints[axis], &drive->joints[axis]) != 0;
    return beyond;
}

/* Torque held within the axis' limit; says so in the limit flags. */
int32_t gimbal_within_torque_limit(const gimbal_settings_t *settings, gimbal_drive_t *drive, int axis, int64_t torque)
{
    const int64_t limit = settings->joints[axis].torque_limit;
    const int64_t held = gimbal_within(torque, -limit, limit);
    if (held != torque)
        drive->limits |= axis == 0 ? GIMBAL_LIMIT_FLAGS_OUTER_TORQUE : GIMBAL_LIMIT_FLAGS_INNER_TORQUE;
    return (int32_t)held;
}

/* Zero in place of a torque that leads further out of travel, or that drives on an axis that is too fast. */
int32_t gimbal_without_outward(const gimbal_axis_settings_t *own, const gimbal_joint_t *joint, int32_t torque)
{
    const int side = beyond_travel(own, joint);
    if ((side > 0 && torque > 0) || (side < 0 && torque < 0))
        return 0;
    const bool too_fast = gimbal_abs(joint->joint_rate) > own->rate_limit;
    const bool drives_on = (torque > 0) == (joint->joint_rate > 0);
    return too_fast && drives_on ? 0 : torque;
}

/* The flags of travel and rate limits as of the sample just taken. */
void gimbal_flag_travel_and_rate(const gimbal_settings_t *settings, gimbal_drive_t *drive)
{
    static const int32_t high[GIMBAL_AXES] = {
        GIMBAL_LIMIT_FLAGS_OUTER_TRAVEL_HIGH, GIMBAL_LIMIT_FLAGS_INNER_TRAVEL_HIGH};
    static const int32_t low[GIMBAL_AXES] = {
        GIMBAL_LIMIT_FLAGS_OUTER_TRAVEL_LOW, GIMBAL_LIMIT_FLAGS_INNER_TRAVEL_LOW};
    static const int32_t rate[GIMBAL_AXES] = {GIMBAL_LIMIT_FLAGS_OUTER_RATE, GIMBAL_LIMIT_FLAGS_INNER_RATE};
    for (int axis = 0; axis < settings->axes; ++axis) {
        const int side = beyond_travel(&settings->joints[axis], &drive->joints[axis]);
        if (side != 0)
            drive->limits |= side > 0 ? high[axis] : low[axis];
        if (gimbal_abs(drive->joints[axis].joint_rate) > settings->joints[axis].rate_limit)
            drive->limits |= rate[axis];
    }
}

/* Guard against a motor that does not do as it is told: momentum that an axis gains against the impulse of its torque.
   The verdict stays until the drive is without power. */
void gimbal_watch_momentum(const gimbal_settings_t *settings, gimbal_drive_t *drive, int axis, int32_t gyro_before)
{
    const gimbal_axis_settings_t *own = &settings->joints[axis];
    gimbal_joint_t *joint = &drive->joints[axis];
    const bool running = drive->state == GIMBAL_DRIVE_STATE_OPERATION_ENABLED && joint->set_enable == 1;
    const bool stopping = gimbal_stops_by_itself(drive);
    if (!running && !stopping)
        joint->ran_away = 0;
    /* what a shorted winding and a brake do to the axis is not the torque's */
    const bool is_free = joint->shorted == 0 && joint->brake_state != GIMBAL_BRAKE_STATE_ENGAGED;
    if (own->strange_impulse == 0 || !(running || stopping) || !is_free) {
        joint->momentum = 0;
        joint->effort = 0;
        joint->peak_torque = 0;
        return;
    }
    const int64_t torque = joint->applied_torque;
    const int64_t kept = settings->momentum_kept;
    const int64_t gained = ((int64_t)joint->gyro - gyro_before) * own->impulse_of_rate - gimbal_scaled(torque);
    joint->momentum = gimbal_floor_scaled(joint->momentum * kept) + gained;
    joint->effort = gimbal_floor_scaled(joint->effort * kept) + gimbal_scaled(gimbal_abs(torque));
    const int64_t faded = gimbal_floor_scaled(joint->peak_torque * kept);
    joint->peak_torque = faded > gimbal_abs(torque) ? faded : gimbal_abs(torque);
    const int64_t allowed = own->strange_impulse + joint->effort / 2 + LATE_TICKS * gimbal_scaled(joint->peak_torque);
    if (gimbal_abs(joint->momentum) > allowed)
        joint->ran_away = 1;
}
