/* What the parts of the device know of each other. Not for its users. */
#ifndef GIMBAL_PARTS_H
#define GIMBAL_PARTS_H

#include "gimbal_device.h"

/* A number of 1 / 2^16 as the whole number below it. */
static inline int64_t gimbal_floor_scaled(int64_t scaled)
{
    const int64_t one = (int64_t)1 << GIMBAL_SCALE_BITS;
    return scaled >= 0 ? scaled / one : -((-scaled + one - 1) / one);
}

static inline int64_t gimbal_scaled(int64_t whole)
{
    return whole * ((int64_t)1 << GIMBAL_SCALE_BITS);
}

static inline int64_t gimbal_abs(int64_t value)
{
    return value < 0 ? -value : value;
}

static inline int64_t gimbal_within(int64_t value, int64_t low, int64_t high)
{
    return value < low ? low : value > high ? high : value;
}

/* --- what a state means, for guards and stops alike */
static inline bool gimbal_has_power(int32_t state)
{
    return state == GIMBAL_DRIVE_STATE_OPERATION_ENABLED || state == GIMBAL_DRIVE_STATE_QUICK_STOP_ACTIVE;
}

static inline bool gimbal_stops_by_itself(const gimbal_drive_t *drive)
{
    return drive->state == GIMBAL_DRIVE_STATE_QUICK_STOP_ACTIVE
        || drive->state == GIMBAL_DRIVE_STATE_FAULT_REACTION_ACTIVE;
}

/* --- gimbal_guards.c */
typedef struct {
    int32_t fault;
    int32_t about;
} gimbal_finding_t;

gimbal_finding_t gimbal_find_fault(const gimbal_settings_t *settings, const gimbal_drive_t *drive);
int64_t gimbal_disagreement(const gimbal_joint_t *joint);
bool gimbal_supply_serves(const gimbal_settings_t *settings, const gimbal_drive_t *drive);
bool gimbal_beyond_any_travel(const gimbal_settings_t *settings, const gimbal_drive_t *drive);
int32_t gimbal_within_torque_limit(const gimbal_settings_t *settings, gimbal_drive_t *drive, int axis, int64_t torque);
int32_t gimbal_without_outward(const gimbal_axis_settings_t *own, const gimbal_joint_t *joint, int32_t torque);
void gimbal_flag_travel_and_rate(const gimbal_settings_t *settings, gimbal_drive_t *drive);
void gimbal_watch_momentum(
    const gimbal_settings_t *settings, gimbal_drive_t *drive, int axis, int32_t gyro_before);

/* --- gimbal_stopping.c, which uses the guards; they do not use it */
void gimbal_begin_stop(const gimbal_settings_t *settings, gimbal_drive_t *drive);
int32_t gimbal_stop_in_force(const gimbal_settings_t *settings, const gimbal_drive_t *drive);
int64_t gimbal_stop_torque(const gimbal_settings_t *settings, gimbal_drive_t *drive, int axis);
void gimbal_count_rest(const gimbal_settings_t *settings, gimbal_drive_t *drive);
bool gimbal_reaction_over(const gimbal_settings_t *settings, const gimbal_drive_t *drive);
void gimbal_hold_axes(const gimbal_settings_t *settings, gimbal_drive_t *drive);

/* --- gimbal_drive.c */
void gimbal_take_set_point(gimbal_device_t *device);
void gimbal_take_deadman_config(gimbal_device_t *device);
void gimbal_take_brake_commands(gimbal_device_t *device);
void gimbal_step_state(gimbal_device_t *device);
int32_t gimbal_destination(int32_t state, int32_t request, bool deadman_fed);

#endif /* GIMBAL_PARTS_H */
