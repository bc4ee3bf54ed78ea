/* How the drive stops by itself: coast, short the winding, torque against the gyro's rate, or a ramp down to rest where
   it then holds; and what holds an axis without torque. */
#include "gimbal_parts.h"

/* Most that the ramp's reference may be ahead of the joint, fraction of a count: far beyond what any torque follows. */
#define MOST_LEAD ((int64_t)1 << 40)

/* By how many ticks of its deceleration the ramp may be faster than the joint. */
#define TICKS_AHEAD 8

/* Where and how fast a ramp begins that acts from this tick on. */
static void take_motion(gimbal_joint_t *joint)
{
    joint->stop_rate = joint->joint_rate;
    joint->stop_lead = 0;
    joint->stop_integral = 0;
    joint->stop_encoder = joint->encoder;
}

/* Take the motion as it is for the start of the ramp. */
void gimbal_begin_stop(const gimbal_settings_t *settings, gimbal_drive_t *drive)
{
    drive->rest_count = 0;
    for (int axis = 0; axis < settings->axes; ++axis)
        take_motion(&drive->joints[axis]);
}

/* Torque that keeps an axis on a ramp to rest and then where it came to rest; PID with the integral held at the torque
   limit. The ramp is never much faster than the joint: a false step of the encoder that it began with, or that comes
   later, is gone from its rate as soon as it is gone from the joint's. */
static int64_t ramp_torque(const gimbal_settings_t *settings, gimbal_joint_t *joint, int axis)
{
    const gimbal_axis_settings_t *own = &settings->joints[axis];
    const int64_t step = own->stop_rate_per_tick;
    int64_t rate = joint->stop_rate;
    const int64_t now = joint->joint_rate;
    if (rate > 0)
        rate = gimbal_within(rate - step, 0, (now > 0 ? now : 0) + TICKS_AHEAD * step);
    else
        rate = gimbal_within(rate + step, (now < 0 ? now : 0) - TICKS_AHEAD * step, 0);
    joint->stop_rate = rate;
    const int64_t moved = (int64_t)joint->encoder - joint->stop_encoder;
    joint->stop_encoder = joint->encoder;
    joint->stop_lead = gimbal_within(
        joint->stop_lead + rate * settings->count_of_rate - gimbal_scaled(moved), -MOST_LEAD, MOST_LEAD);
    const int64_t error = gimbal_floor_scaled(joint->stop_lead);
    const int64_t most = gimbal_scaled(own->torque_limit);
    joint->stop_integral = gimbal_within(joint->stop_integral + error * own->stop_integral_gain, -most, most);
    return gimbal_floor_scaled(
        own->stop_rate_gain * (rate - joint->joint_rate) + own->stop_position_gain * error + joint->stop_integral);
}

/* Torque against the inertial rate that the gyro reads. */
static int64_t gyro_torque(const gimbal_axis_settings_t *own, const gimbal_joint_t *joint)
{
    return gimbal_floor_scaled(-(own->stop_rate_gain * joint->gyro));
}

/* The stop that acts now: the one chosen while what it needs serves, else the shorted winding, which needs nothing. */
int32_t gimbal_stop_in_force(const gimbal_settings_t *settings, const gimbal_drive_t *drive)
{
    const int32_t reaction = drive->active_reaction;
    if (reaction != GIMBAL_STOP_REACTION_DECELERATE_AND_HOLD && reaction != GIMBAL_STOP_REACTION_GYRO_STOP)
        return reaction;
    if (!gimbal_supply_serves(settings, drive))
        return GIMBAL_STOP_REACTION_BRAKE;
    const int32_t broken =
        reaction == GIMBAL_STOP_REACTION_DECELERATE_AND_HOLD ? GIMBAL_FAULT_CODE_ENCODER : GIMBAL_FAULT_CODE_GYRO;
    for (int axis = 0; axis < settings->axes; ++axis) {
        const gimbal_joint_t *joint = &drive->joints[axis];
        if (joint->ran_away == 1)
            return GIMBAL_STOP_REACTION_BRAKE;
        if (joint->sensor_fault == broken || joint->sensor_fault == GIMBAL_FAULT_CODE_INTERNAL
            || gimbal_disagreement(joint) > settings->stop_disagreement)
            return GIMBAL_STOP_REACTION_BRAKE;
    }
    return reaction;
}

/* Torque of the stop in force; a coasting axis and a shorted winding get none. A ramp begins when it acts: from the
   motion after a short that stood in for it, not from the one that called for the short. */
int64_t gimbal_stop_torque(const gimbal_settings_t *settings, gimbal_drive_t *drive, int axis)
{
    const int32_t stop = gimbal_stop_in_force(settings, drive);
    if (stop == GIMBAL_STOP_REACTION_DECELERATE_AND_HOLD)
        return ramp_torque(settings, &drive->joints[axis], axis);
    take_motion(&drive->joints[axis]);
    if (stop == GIMBAL_STOP_REACTION_GYRO_STOP)
        return gyro_torque(&settings->joints[axis], &drive->joints[axis]);
    return 0;
}

/* Count the ticks in a row in which every axis was at rest. */
void gimbal_count_rest(const gimbal_settings_t *settings, gimbal_drive_t *drive)
{
    for (int axis = 0; axis < settings->axes; ++axis) {
        if (gimbal_abs(drive->joints[axis].joint_rate) > settings->rest_rate) {
            drive->rest_count = 0;
            return;
        }
    }
    if (drive->rest_count < INT32_MAX)
        drive->rest_count += 1;
}

/* Whether the fault reaction has done what it can: at rest, held for its time, or out of time. */
bool gimbal_reaction_over(const gimbal_settings_t *settings, const gimbal_drive_t *drive)
{
    if (drive->active_reaction == GIMBAL_STOP_REACTION_COAST)
        return true;
    const int32_t hold =
        drive->active_reaction == GIMBAL_STOP_REACTION_DECELERATE_AND_HOLD ? settings->hold_ticks : 0;
    return drive->rest_count >= settings->rest_ticks + hold || drive->state_age >= settings->reaction_ticks + hold;
}

/* Whether an axis' brake is to be closed: by command, or by itself whenever nothing else holds the antenna. */
static bool wants_brake(
    const gimbal_settings_t *settings, const gimbal_drive_t *drive, const gimbal_joint_t *joint, int32_t stop)
{
    if (joint->brake_command != GIMBAL_BRAKE_COMMAND_AUTOMATIC)
        return joint->brake_command == GIMBAL_BRAKE_COMMAND_ENGAGE;
    if (drive->state == GIMBAL_DRIVE_STATE_OPERATION_ENABLED)
        /* an axis that a plan leaves free beside one under torque may swing */
        return drive->joints[0].set_enable == 0 && drive->joints[1].set_enable == 0;
    if (gimbal_stops_by_itself(drive)
        && (stop == GIMBAL_STOP_REACTION_DECELERATE_AND_HOLD || stop == GIMBAL_STOP_REACTION_GYRO_STOP))
        /* torque stops the axis; the brake closes at rest, while torque still holds it */
        return drive->rest_count >= settings->rest_ticks;
    return true;
}

/* Short the windings and close or open the brakes for this tick: a brake opens at once and takes its time to close. */
void gimbal_hold_axes(const gimbal_settings_t *settings, gimbal_drive_t *drive)
{
    const int32_t stop = gimbal_stop_in_force(settings, drive);
    /* without power the winding is shorted, because nothing else slows an axis that has no brake; one that was told to
       coast coasts */
    const bool stopped = gimbal_stops_by_itself(drive) || drive->state == GIMBAL_DRIVE_STATE_FAULT;
    const bool shorted =
        stopped ? stop == GIMBAL_STOP_REACTION_BRAKE : drive->state != GIMBAL_DRIVE_STATE_OPERATION_ENABLED;
    for (int axis = 0; axis < settings->axes; ++axis) {
        gimbal_joint_t *joint = &drive->joints[axis];
        joint->shorted = shorted ? 1 : 0;
        if (settings->joints[axis].has_brake != 1)
            continue;
        if (!wants_brake(settings, drive, joint, stop)) {
            joint->brake_state = GIMBAL_BRAKE_STATE_RELEASED;
            joint->brake_age = 0;
        } else if (joint->brake_age < settings->brake_ticks) {
            joint->brake_age += 1;
        } else {
            joint->brake_state = GIMBAL_BRAKE_STATE_ENGAGED;
        }
    }
}
