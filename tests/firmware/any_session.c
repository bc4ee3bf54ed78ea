/* Any session of any length with any frames and any sensors, for the analyser (frama-c -eva): every torque that is asked
 * of the current loop is within its limit. */
#include "gimbal_device.h"
#include "gimbal_settings.h"
#include "__fc_builtin.h"

static int32_t any(void)
{
    return Frama_C_int_interval(INT32_MIN, INT32_MAX);
}
static int32_t supply(void *context)
{
    return any();
}
static void actuate(void *context, int axis, const gimbal_actuation_t *wanted)
{
    //@ assert within: -gimbal_settings.joints[axis].torque_limit <= wanted->torque <= gimbal_settings.joints[axis].torque_limit;
}
static void sample(void *context, int axis, gimbal_sample_t *sampled)
{
    sampled->position = any(); sampled->rate = any(); sampled->torque = any(); sampled->winding = any();
    sampled->valid = Frama_C_nondet(0, 1);
}
static void base(void *context, gimbal_base_t *b)
{
    b->roll = any(); b->pitch = any(); b->yaw = any(); b->p = any(); b->q = any(); b->r = any();
    b->ax = any(); b->ay = any(); b->az = any();
}
static void send(void *context, uint16_t id, const uint8_t payload[GIMBAL_PAYLOAD_SIZE]) {}
static const gimbal_hardware_t hardware = {0, supply, actuate, sample, base, send};
static gimbal_device_t device;
int main(void)
{
    gimbal_device_start(&device, &gimbal_settings, &hardware);
    while (Frama_C_nondet(0, 1)) {
        gimbal_device_begin(&device);
        while (Frama_C_nondet(0, 1)) {
            uint8_t payload[GIMBAL_PAYLOAD_SIZE];
            for (int i = 0; i < GIMBAL_PAYLOAD_SIZE; ++i) payload[i] = (uint8_t)Frama_C_int_interval(0, 255);
            gimbal_device_receive(&device, (uint16_t)Frama_C_int_interval(0, 65535), payload);
        }
        gimbal_device_tick(&device);
    }
    return 0;
}
