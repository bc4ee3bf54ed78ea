/* The device as the firmware of a whole board, simulated: start-up, a UART with its interrupt, a tick at every edge.
 *
 * The board is the MPS2 with image AN386, a Cortex-M4 that QEMU imitates. Its time is the host's (lockstep in
 * docs/reference/wire.md), so it need not be fast. What a real board has as motors, sensors and a flash page of settings is here a pair of pipes,
 * read and written through semihosting, a whole record at a time.
 */
#include <stddef.h>

#include "gimbal_device.h"
#include "gimbal_stream.h"

#define REGISTER(address) (*(volatile uint32_t *)(address))
#define UART_DATA REGISTER(0x40004000u)
#define UART_STATE REGISTER(0x40004004u)
#define UART_CONTROL REGISTER(0x40004008u)
#define UART_INTERRUPTS REGISTER(0x4000400Cu)
#define UART_DIVIDER REGISTER(0x40004010u)
#define UART_SEND_FULL 1u
#define UART_HAS_BYTE 2u
#define UART_SEND_RECEIVE_INTERRUPT 0x0Bu
#define UART_RECEIVED 2u
#define INTERRUPT_ENABLE REGISTER(0xE000E100u)
#define INTERRUPT_FORGET REGISTER(0xE000E280u)
#define RECEIVE_INTERRUPT 1u

#define SYS_OPEN 0x01u
#define SYS_WRITE 0x05u
#define SYS_READ 0x06u
#define SYS_EXIT 0x18u
#define MODE_READ 1u
#define MODE_WRITE 5u

extern uint32_t bss_begin[];
extern uint32_t bss_end[];
void start(void);

/* What goes to the plant and comes from it in each tick, little endian. */
typedef struct {
    int32_t torque[GIMBAL_AXES];
    uint8_t powered[GIMBAL_AXES];
    uint8_t shorted[GIMBAL_AXES];
    uint8_t brake_held[GIMBAL_AXES]; /* and two bytes of padding */
} to_plant_t;

typedef struct {
    int32_t position[GIMBAL_AXES];
    int32_t rate[GIMBAL_AXES];
    int32_t torque[GIMBAL_AXES];
    int32_t winding[GIMBAL_AXES];
    int32_t valid[GIMBAL_AXES];
    gimbal_base_t base;
    int32_t supply;
} from_plant_t;

static gimbal_settings_t settings;
static gimbal_device_t device;
static gimbal_stream_t line;
static gimbal_packet_t packet;
static to_plant_t to_plant;
static from_plant_t from_plant;
static uint32_t plant_out;
static uint32_t plant_in;
/* number of the last edge, and whether it asked for a tick */
static uint32_t edge;
static bool tick_is_due;
/* for whoever looks into this memory: the device has its settings and waits for its first edge */
static volatile bool started;

/* One request to the machine that runs QEMU: what it answers. */
static uint32_t ask_host(uint32_t request, const void *words)
{
    register uint32_t r0 __asm__("r0") = request;
    register const void *r1 __asm__("r1") = words;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static uint32_t address(const void *place)
{
    return (uint32_t)(uintptr_t)place;
}

static uint32_t open_pipe(const char *name, uint32_t size, uint32_t mode)
{
    const uint32_t words[3] = {address(name), mode, size};
    return ask_host(SYS_OPEN, words);
}

static void read_plant(void *record, uint32_t size)
{
    const uint32_t words[3] = {plant_in, address(record), size};
    /* it answers how many bytes are missing: without a plant there is nothing to do */
    if (ask_host(SYS_READ, words) != 0u)
        (void)ask_host(SYS_EXIT, NULL);
}

static int32_t read_supply(void *context)
{
    (void)context;
    return from_plant.supply;
}

static void actuate(void *context, int axis, const gimbal_actuation_t *wanted)
{
    (void)context;
    to_plant.torque[axis] = wanted->torque;
    to_plant.powered[axis] = wanted->powered ? 1u : 0u;
    to_plant.shorted[axis] = wanted->shorted ? 1u : 0u;
    to_plant.brake_held[axis] = wanted->brake_held ? 1u : 0u;
}

static void sample(void *context, int axis, gimbal_sample_t *sampled)
{
    (void)context;
    if (axis == 0) {
        const uint32_t words[3] = {plant_out, address(&to_plant), sizeof to_plant};
        (void)ask_host(SYS_WRITE, words);
        read_plant(&from_plant, sizeof from_plant);
    }
    sampled->position = from_plant.position[axis];
    sampled->rate = from_plant.rate[axis];
    sampled->torque = from_plant.torque[axis];
    sampled->winding = from_plant.winding[axis];
    sampled->valid = from_plant.valid[axis] == 1;
}

static void base(void *context, gimbal_base_t *now)
{
    (void)context;
    *now = from_plant.base;
}

static void send(void *context, uint16_t id, const uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    (void)context;
    (void)gimbal_packet_add(&packet, id, payload);
}

static const gimbal_hardware_t hardware = {
    .context = NULL, .supply = read_supply, .actuate = actuate, .sample = sample, .base = base, .send = send};

/* End what is sent with the edge that is answered, and send it. */
static void answer(void)
{
    uint8_t payload[GIMBAL_PAYLOAD_SIZE];
    gimbal_seal(GIMBAL_EDGE_DATA_ID, edge, (uint8_t)(edge & 0x0Fu), payload);
    send(NULL, GIMBAL_EDGE_ID, payload);
    const uint32_t size = gimbal_packet_end(&packet);
    for (uint32_t place = 0; place < size; ++place) {
        while ((UART_STATE & UART_SEND_FULL) != 0u) {
        }
        UART_DATA = packet.packet[place];
    }
}

static void take(void *context, uint16_t id, const uint8_t payload[GIMBAL_PAYLOAD_SIZE])
{
    (void)context;
    uint64_t number;
    if (id != GIMBAL_EDGE_ID || !gimbal_unseal(GIMBAL_EDGE_DATA_ID, payload, &number)) {
        (void)gimbal_device_receive(&device, id, payload);
    } else if (number == 0u) {
        /* a host begins: it is answered, and what came before is not for it */
        gimbal_device_begin(&device);
        edge = 0;
        answer();
    } else if (number == (edge == UINT32_MAX ? 1u : edge + 1u)) {
        edge = (uint32_t)number;
        tick_is_due = true;
    }
}

/* Sleep until the host has sent an edge. Interrupts are masked: they wake the core and call nothing. */
static void wait_for_edge(void)
{
    while (!tick_is_due) {
        while ((UART_STATE & UART_HAS_BYTE) == 0u) {
            __asm__ volatile("wfi");
            UART_INTERRUPTS = UART_RECEIVED;
            INTERRUPT_FORGET = RECEIVE_INTERRUPT;
        }
        (void)gimbal_stream_feed(&line, (uint8_t)UART_DATA, take, NULL);
    }
    tick_is_due = false;
}

static void run(void)
{
    static const char out[] = "to_plant";
    static const char in[] = "from_plant";
    __asm__ volatile("cpsid i");
    UART_DIVIDER = 16u;
    UART_CONTROL = UART_SEND_RECEIVE_INTERRUPT;
    INTERRUPT_ENABLE = RECEIVE_INTERRUPT;
    plant_out = open_pipe(out, sizeof out - 1u, MODE_WRITE);
    plant_in = open_pipe(in, sizeof in - 1u, MODE_READ);
    read_plant(&settings, sizeof settings);
    read_plant(&from_plant, sizeof from_plant);
    gimbal_device_start(&device, &settings, &hardware);
    gimbal_device_begin(&device);
    started = true;
    for (;;) {
        wait_for_edge();
        gimbal_device_tick(&device);
        /* before the answer: from then on whoever looks into this memory finds it at rest */
        gimbal_device_begin(&device);
        answer();
    }
}

void start(void)
{
    const uint32_t words = (address(bss_end) - address(bss_begin)) / sizeof(uint32_t);
    for (uint32_t place = 0; place < words; ++place)
        bss_begin[place] = 0u;
    run();
}

__attribute__((section(".vectors"), used)) static const uintptr_t vectors[2] = {0x21040000u, (uintptr_t)start};
