/* The drive's state machine after CiA 402 (IEC 61800-7-201) and what it hears of the host.
 *
 * At most one transition a tick, so that one drive_event tells of every one. Requests act in the tick in which their
 * frame arrives; a fault outranks them all.
 */
#include "gimbal_parts.h"

/* `detail` of a drive_event that no request and no fault explains, and of a fault that was reset */
#define DETAIL_BY_ITSELF 0
#define DETAIL_FAULT_RESET 7

/* Let the deadman run by one tick, and feed it if a fresh set-point with a new sequence came. */
void gimbal_take_set_point(gimbal_device_t *device)
{
    gimbal_drive_t *drive = &device->drive;
    const int32_t margin = drive->margin;
    drive->margin = margin > 1 ? margin - 1 : 0;
    if (!device->fresh[GIMBAL_HEARD_SET_POINT])
        return;
    const int32_t sequence = device->set_point.sequence;
    const uint32_t ahead = ((uint32_t)sequence - (uint32_t)drive->last_sequence) & 1023u;
    /* a repeat never counts; one from behind only when the deadman has run out, because then it is a host that started
       anew */
    if (drive->last_sequence >= 0 && (ahead == 0 || (ahead >= 512 && margin > 0))) {
        drive->refused += 1u;
        return;
    }
    drive->taken += 1u;
    drive->last_sequence = sequence;
    drive->margin = drive->window;
    drive->joints[0].set_torque = device->set_point.torque_outer;
    drive->joints[1].set_torque = device->set_point.torque_inner;
    drive->joints[0].set_enable = device->set_point.enable_outer ? 1 : 0;
    drive->joints[1].set_enable = device->set_point.enable_inner ? 1 : 0;
}

/* Take the host's deadman over, never while it guards torque. */
void gimbal_take_deadman_config(gimbal_device_t *device)
{
    gimbal_drive_t *drive = &device->drive;
    if (device->fresh[GIMBAL_HEARD_DEADMAN_CONFIG] && !gimbal_has_power(drive->state)
        && drive->state != GIMBAL_DRIVE_STATE_FAULT_REACTION_ACTIVE) {
        drive->window = device->deadman.window_ticks;
        drive->reaction = device->deadman.reaction;
        drive->margin = drive->margin < drive->window ? drive->margin : drive->window;
    }
}

void gimbal_take_brake_commands(gimbal_device_t *device)
{
    if (!device->fresh[GIMBAL_HEARD_DRIVE_CONTROL])
        return;
    device->drive.joints[0].brake_command = device->control.brake_outer;
    device->drive.joints[1].brake_command = device->control.brake_inner;
}

/* Go over to a state and tell of it. */
static void enter(gimbal_device_t *device, int32_t state, int32_t cause, int32_t detail)
{
    gimbal_drive_t *drive = &device->drive;
    device->has_event = true;
    device->event.from_state = (uint8_t)drive->state;
    device->event.to_state = (uint8_t)state;
    device->event.cause = (uint8_t)cause;
    device->event.detail = (uint8_t)detail;
    device->event.tick = (uint16_t)(drive->tick & 4095u);
    drive->state = state;
    drive->state_age = 0;
}

/* Take drive_control's levels; whether fault_reset rose. */
static bool hear_control(gimbal_device_t *device)
{
    gimbal_drive_t *drive = &device->drive;
    const bool beyond = gimbal_beyond_any_travel(device->settings, drive);
    if (drive->travel_cleared == 1 && !beyond)
        drive->travel_cleared = 0;
    if (!device->fresh[GIMBAL_HEARD_DRIVE_CONTROL])
        return false;
    drive->control_age = 0;
    /* cleared while it is out of travel only: once back inside, the next time is a fault again */
    drive->travel_cleared = device->control.clear_travel && beyond ? 1 : 0;
    const int32_t level = device->control.fault_reset ? 1 : 0;
    const bool rose = level == 1 && drive->reset_level == 0;
    drive->reset_level = level;
    return rose;
}

/* Without power there is nothing to stop; a lost link has the reaction that the host chose, but a stop that uses no
   sensor goes on: the host had a reason to ask for it before it fell silent. */
static int32_t reaction_to(const gimbal_settings_t *settings, const gimbal_drive_t *drive, int32_t fault)
{
    if (!gimbal_has_power(drive->state))
        return GIMBAL_STOP_REACTION_COAST;
    if (fault == GIMBAL_FAULT_CODE_DEADMAN || fault == GIMBAL_FAULT_CODE_COMMUNICATION) {
        const bool without_sensor = drive->state == GIMBAL_DRIVE_STATE_QUICK_STOP_ACTIVE
            && drive->active_reaction <= GIMBAL_STOP_REACTION_BRAKE;
        return without_sensor ? drive->active_reaction : drive->reaction;
    }
    return settings->fault_reaction;
}

/* Where a request leads: the transitions of CiA 402 without the optional 16, so a quick stop is left through
   SWITCH_ON_DISABLED. Torque is not switched on before set-points come. */
int32_t gimbal_destination(int32_t state, int32_t request, bool deadman_fed)
{
    switch (request) {
    case GIMBAL_DRIVE_REQUEST_DISABLE_VOLTAGE:
        return GIMBAL_DRIVE_STATE_SWITCH_ON_DISABLED;
    case GIMBAL_DRIVE_REQUEST_QUICK_STOP:
        if (state == GIMBAL_DRIVE_STATE_OPERATION_ENABLED || state == GIMBAL_DRIVE_STATE_QUICK_STOP_ACTIVE)
            return GIMBAL_DRIVE_STATE_QUICK_STOP_ACTIVE;
        return GIMBAL_DRIVE_STATE_SWITCH_ON_DISABLED;
    case GIMBAL_DRIVE_REQUEST_SHUTDOWN:
        return state != GIMBAL_DRIVE_STATE_QUICK_STOP_ACTIVE ? GIMBAL_DRIVE_STATE_READY_TO_SWITCH_ON : state;
    case GIMBAL_DRIVE_REQUEST_SWITCH_ON:
        return state == GIMBAL_DRIVE_STATE_READY_TO_SWITCH_ON ? GIMBAL_DRIVE_STATE_SWITCHED_ON : state;
    case GIMBAL_DRIVE_REQUEST_DISABLE_OPERATION:
        return state == GIMBAL_DRIVE_STATE_OPERATION_ENABLED ? GIMBAL_DRIVE_STATE_SWITCHED_ON : state;
    case GIMBAL_DRIVE_REQUEST_ENABLE_OPERATION:
        return state == GIMBAL_DRIVE_STATE_SWITCHED_ON && deadman_fed ? GIMBAL_DRIVE_STATE_OPERATION_ENABLED : state;
    default:
        return state;
    }
}

/* Whether a quick stop that runs shall go on without the sensor that it uses; one that uses none stays. */
static bool asks_for_another_stop(const gimbal_device_t *device)
{
    const int32_t active = device->drive.active_reaction;
    return device->control.quick_stop && device->control.stop != active && active > GIMBAL_STOP_REACTION_BRAKE;
}

static void follow_request(gimbal_device_t *device)
{
    gimbal_drive_t *drive = &device->drive;
    const int32_t state = drive->state;
    int32_t request = device->control.request;
    if (device->control.quick_stop && state != GIMBAL_DRIVE_STATE_QUICK_STOP_ACTIVE)
        request = GIMBAL_DRIVE_REQUEST_QUICK_STOP;
    const int32_t wanted = gimbal_destination(state, request, drive->margin > 0);
    if (wanted == GIMBAL_DRIVE_STATE_QUICK_STOP_ACTIVE && (state != wanted || asks_for_another_stop(device))) {
        drive->active_reaction = device->control.stop;
        gimbal_begin_stop(device->settings, drive);
    }
    if (wanted != state)
        enter(device, wanted, GIMBAL_FAULT_CODE_NONE, request);
}

static int32_t one_more(int32_t count)
{
    return count < INT32_MAX ? count + 1 : count;
}

/* One tick of the state machine. */
void gimbal_step_state(gimbal_device_t *device)
{
    const gimbal_settings_t *settings = device->settings;
    gimbal_drive_t *drive = &device->drive;
    drive->state_age = one_more(drive->state_age);
    drive->control_age = one_more(drive->control_age);
    const bool reset_edge = hear_control(device);
    gimbal_count_rest(settings, drive);
    const gimbal_finding_t now = gimbal_find_fault(settings, drive);
    if (drive->state == GIMBAL_DRIVE_STATE_FAULT_REACTION_ACTIVE) {
        if (gimbal_reaction_over(settings, drive))
            enter(device, GIMBAL_DRIVE_STATE_FAULT, drive->fault, drive->fault_detail);
    } else if (drive->state == GIMBAL_DRIVE_STATE_FAULT) {
        if (reset_edge && now.fault == GIMBAL_FAULT_CODE_NONE) {
            drive->fault = GIMBAL_FAULT_CODE_NONE;
            enter(device, GIMBAL_DRIVE_STATE_SWITCH_ON_DISABLED, GIMBAL_FAULT_CODE_NONE, DETAIL_FAULT_RESET);
        }
    } else if (now.fault != GIMBAL_FAULT_CODE_NONE) {
        drive->fault = now.fault;
        drive->fault_detail = now.about;
        drive->active_reaction = reaction_to(settings, drive, now.fault);
        gimbal_begin_stop(settings, drive);
        enter(device, GIMBAL_DRIVE_STATE_FAULT_REACTION_ACTIVE, now.fault, now.about);
    } else if (drive->state == GIMBAL_DRIVE_STATE_NOT_READY) {
        if (drive->state_age >= settings->startup_ticks)
            enter(device, GIMBAL_DRIVE_STATE_SWITCH_ON_DISABLED, GIMBAL_FAULT_CODE_NONE, DETAIL_BY_ITSELF);
    } else if (device->fresh[GIMBAL_HEARD_DRIVE_CONTROL]) {
        follow_request(device);
    }
}
