/* The virtual antenna as an FMU: FMI 3.0 co-simulation around the compiled tick, frames over FMI-LS-BUS (CAN).
 *
 * Sources: FMI 3.0.2 (functions and their states), FMI-LS-BUS 1.0.0 (network abstraction, CAN). What is the model's
 * stands in resources/antenna.bin, so that one library serves every model: `struct layout`, then the antenna's words.
 */

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum status { OK, WARNING, DISCARD, ERROR, FATAL };
enum reference { TIME, RX_DATA, TX_DATA, RX_CLOCK, TX_CLOCK, SEED, STATE, FAULT, BAD_FRAMES, FIRST_AXIS = 16 };
enum of_axis { POSITION, RATE, TORQUE, TEMPERATURE, PER_AXIS };
enum operation { FORMAT_ERROR = 0x01, CAN_TRANSMIT = 0x10 };
/* of an operation: code and length; of a transmit: identifier, IDE, RTR, length of the data; of a frame in a block */
enum sizes { HEAD = 8, TRANSMIT = 16, RECORD = 10, PAYLOAD = 8, TOKEN = 40 };

typedef void (*log_message)(void *environment, int status, const char *category, const char *message);

/* as `sim_backend.fmu.package` writes it */
struct layout {
    char token[TOKEN];
    double rate_hz;
    int64_t words, x_size, axes, octets_at, floats_at, received_size, answer_at;
    int64_t seed_at, state_at, fault_at, receivers_at, receiver_rows, receiver_columns, crc_errors, out_of_range;
    int64_t position_at, rate_at, torque_at, temperature_at;
};

struct buffer {
    uint8_t *bytes;
    size_t size, room;
};

struct antenna {
    struct layout layout;
    int64_t *words, *initial;
    /* frames for the next tick, as records; operations as set; those of the last step; complaints for the next */
    struct buffer records, received, sent, complaints;
    double start;
    int64_t ticks;
    bool event_mode_used, sending;
    void *environment;
    log_message log;
};

/* the compiled tick, by the calling convention of Numba: an array is seven arguments */
int gimbal_tick(int64_t *answer, void **raised, void *info, void *parent, int64_t items, int64_t item_size,
                int64_t *data, int64_t shape, int64_t stride, int64_t x_size, int64_t received);

/* what the compiled tick asks of Numba's own library: the strides of a contiguous array in another shape */
int numba_attempt_nocopy_reshape(intptr_t dimensions, const intptr_t *shape, const intptr_t *strides,
                                 intptr_t new_dimensions, const intptr_t *new_shape, intptr_t *new_strides,
                                 intptr_t item_size, int fortran_order)
{
    (void)strides;
    intptr_t before = 1, after = 1, stride = item_size;
    for (intptr_t k = 0; k < dimensions; k++) before *= shape[k];
    for (intptr_t k = 0; k < new_dimensions; k++) after *= new_shape[k];
    if (before != after || fortran_order) return 0;
    for (intptr_t k = new_dimensions; k-- > 0; stride *= new_shape[k]) new_strides[k] = stride;
    return 1;
}

static int complain(const struct antenna *antenna, const char *message)
{
    if (antenna->log) antenna->log(antenna->environment, ERROR, "logStatusError", message);
    return ERROR;
}

static bool add(struct buffer *buffer, const void *bytes, size_t size)
{
    if (buffer->size + size > buffer->room) {
        size_t room = 2 * (buffer->size + size);
        uint8_t *moved = realloc(buffer->bytes, room);
        if (!moved) return false;
        buffer->bytes = moved, buffer->room = room;
    }
    if (size) memcpy(buffer->bytes + buffer->size, bytes, size);
    buffer->size += size;
    return true;
}

static void put(uint8_t *at, uint64_t value, size_t bytes)
{
    for (size_t k = 0; k < bytes; k++) at[k] = (uint8_t)(value >> (8 * k));
}

static uint32_t take(const uint8_t *at, size_t bytes)
{
    uint32_t value = 0;
    for (size_t k = 0; k < bytes; k++) value |= (uint32_t)at[k] << (8 * k);
    return value;
}

/* --- operations of the bus ------------------------------------------------------------------------------------- */

static bool refuse(struct antenna *antenna, const uint8_t *at, size_t size)
{
    uint8_t head[HEAD + 2];
    if (size > UINT16_MAX) size = UINT16_MAX;
    put(head, FORMAT_ERROR, 4), put(head + 4, HEAD + 2 + size, 4), put(head + HEAD, size, 2);
    return add(&antenna->complaints, head, sizeof head) && add(&antenna->complaints, at, size);
}

/* Frames of the operations received, for the next tick. A frame that no message of the antenna can be is not for it. */
static bool hear(struct antenna *antenna)
{
    const uint8_t *at = antenna->received.bytes;
    size_t left = antenna->received.size;
    antenna->received.size = 0;
    while (left) {
        uint32_t length = left < HEAD ? 0 : take(at + 4, 4);
        bool transmit = length >= HEAD && take(at, 4) == CAN_TRANSMIT;
        bool whole = length >= HEAD && length <= left;
        if (transmit) whole = whole && length >= TRANSMIT && length == TRANSMIT + take(at + 14, 2);
        if (!whole) return refuse(antenna, at, left);
        bool plain = transmit && !at[12] && !at[13] && length == TRANSMIT + PAYLOAD && take(at + 8, 4) <= 0x7FF;
        if (plain && !add(&antenna->records, at + 8, 2)) return false;
        if (plain && !add(&antenna->records, at + TRANSMIT, PAYLOAD)) return false;
        at += length, left -= length;
    }
    return true;
}

static bool say(struct antenna *antenna, const uint8_t *records, int64_t size)
{
    uint8_t operation[TRANSMIT + PAYLOAD] = {0};
    put(operation, CAN_TRANSMIT, 4), put(operation + 4, sizeof operation, 4), put(operation + 14, PAYLOAD, 2);
    for (int64_t at = 0; at < size; at += RECORD) {
        memcpy(operation + 8, records + at, 2), memcpy(operation + TRANSMIT, records + at + 2, PAYLOAD);
        if (!add(&antenna->sent, operation, sizeof operation)) return false;
    }
    return true;
}

static bool tick(struct antenna *antenna)
{
    const struct layout *layout = &antenna->layout;
    uint8_t *octets = (uint8_t *)(antenna->words + layout->octets_at);
    /* of too many the newest count, as for the antenna in Python */
    size_t size = antenna->records.size, most = (size_t)(layout->received_size - layout->received_size % RECORD);
    size_t skipped = size > most ? size - most : 0;
    if (size) memcpy(octets, antenna->records.bytes + skipped, size - skipped);
    antenna->records.size = 0;
    int64_t sent = 0;
    void *raised = NULL;
    if (gimbal_tick(&sent, &raised, NULL, NULL, layout->words, sizeof(int64_t), antenna->words, layout->words,
                    sizeof(int64_t), layout->x_size, (int64_t)(size - skipped)))
        return false;
    antenna->ticks++;
    return say(antenna, octets + layout->answer_at, sent);
}

/* --- life ------------------------------------------------------------------------------------------------------- */

static void start_anew(struct antenna *antenna)
{
    memcpy(antenna->words, antenna->initial, (size_t)antenna->layout.words * sizeof(int64_t));
    antenna->records.size = antenna->received.size = antenna->sent.size = antenna->complaints.size = 0;
    antenna->ticks = 0, antenna->sending = false;
}

static bool read_antenna(struct antenna *antenna, const char *folder)
{
    static const char name[] = "/antenna.bin";
    char *path = malloc(strlen(folder) + sizeof name);
    if (!path) return false;
    strcat(strcpy(path, folder), name);
    FILE *file = fopen(path, "rb");
    free(path);
    if (!file) return false;
    bool good = fread(&antenna->layout, sizeof antenna->layout, 1, file) == 1;
    size_t words = good ? (size_t)antenna->layout.words : 0;
    antenna->words = malloc(words * sizeof(int64_t)), antenna->initial = malloc(words * sizeof(int64_t));
    good = good && antenna->words && antenna->initial && fread(antenna->initial, sizeof(int64_t), words, file) == words;
    fclose(file);
    return good;
}

void fmi3FreeInstance(void *instance)
{
    struct antenna *antenna = instance;
    if (!antenna) return;
    free(antenna->words), free(antenna->initial), free(antenna->records.bytes), free(antenna->received.bytes);
    free(antenna->sent.bytes), free(antenna->complaints.bytes), free(antenna);
}

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible,
                                  bool logging, bool event_mode_used, bool early_return, const uint32_t wanted[],
                                  size_t count, void *environment, log_message log, void *intermediate)
{
    (void)name, (void)visible, (void)logging, (void)early_return, (void)wanted, (void)count, (void)intermediate;
    struct antenna *antenna = calloc(1, sizeof *antenna);
    if (!antenna) return NULL;
    antenna->environment = environment, antenna->log = log, antenna->event_mode_used = event_mode_used;
    if (!resources || !read_antenna(antenna, resources)) {
        complain(antenna, "antenna.bin cannot be read: give fmi3InstantiateCoSimulation the folder of resources");
    } else if (!token || strncmp(token, antenna->layout.token, TOKEN)) {
        complain(antenna, "the instantiation token is that of another FMU: take it from modelDescription.xml");
    } else {
        start_anew(antenna);
        return antenna;
    }
    fmi3FreeInstance(antenna);
    return NULL;
}

const char *fmi3GetVersion(void) { return "3.0"; }

int fmi3SetDebugLogging(void *instance, bool logging, size_t count, const char *const categories[])
{
    (void)instance, (void)logging, (void)count, (void)categories;
    return OK;
}

int fmi3EnterInitializationMode(void *instance, bool has_tolerance, double tolerance, double start, bool has_stop,
                                double stop)
{
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    ((struct antenna *)instance)->start = start;
    return OK;
}

int fmi3ExitInitializationMode(void *instance) { return instance ? OK : ERROR; }
int fmi3EnterEventMode(void *instance) { return instance ? OK : ERROR; }
int fmi3Terminate(void *instance) { return instance ? OK : ERROR; }

int fmi3Reset(void *instance)
{
    start_anew(instance);
    return OK;
}

int fmi3EnterStepMode(void *instance)
{
    return hear(instance) ? OK : complain(instance, "out of memory");
}

int fmi3UpdateDiscreteStates(void *instance, bool *again, bool *terminate, bool *nominals, bool *values, bool *defined,
                             double *next)
{
    ((struct antenna *)instance)->sending = false;
    *again = *terminate = *nominals = *values = *defined = false, *next = 0.0;
    return hear(instance) ? OK : complain(instance, "out of memory");
}

int fmi3DoStep(void *instance, double now, double step, bool no_set_state, bool *event, bool *terminate, bool *early,
               double *reached)
{
    (void)no_set_state;
    struct antenna *antenna = instance;
    *event = *terminate = *early = false, *reached = now + step;
    /* a tick that the step ends on is made in it, whatever the rounding of the importer's time */
    int64_t wanted = (int64_t)floor((now + step - antenna->start) * antenna->layout.rate_hz + 1e-6);
    bool good = hear(antenna);
    antenna->sent.size = 0;
    good = good && add(&antenna->sent, antenna->complaints.bytes, antenna->complaints.size);
    antenna->complaints.size = 0;
    while (good && antenna->ticks < wanted) good = tick(antenna);
    antenna->sending = antenna->sent.size > 0;
    *event = antenna->event_mode_used && antenna->sending;
    return good ? OK : complain(antenna, "a tick failed: out of memory");
}

/* --- variables --------------------------------------------------------------------------------------------------- */

static bool number(const struct antenna *antenna, uint32_t reference, double *value)
{
    const struct layout *layout = &antenna->layout;
    if (reference == TIME) {
        *value = antenna->start + (double)antenna->ticks / layout->rate_hz;
        return true;
    }
    uint32_t axis = (reference - FIRST_AXIS) / PER_AXIS;
    if (reference < FIRST_AXIS || axis >= layout->axes) return false;
    int64_t first[PER_AXIS] = {layout->position_at, layout->rate_at, layout->torque_at, layout->temperature_at};
    int64_t place = layout->floats_at + first[(reference - FIRST_AXIS) % PER_AXIS] + axis;
    memcpy(value, antenna->words + place, sizeof *value);
    return true;
}

static int64_t bad_frames(const struct antenna *antenna)
{
    const struct layout *layout = &antenna->layout;
    const int64_t *row = antenna->words + layout->receivers_at;
    int64_t sum = 0;
    for (int64_t k = 0; k + 1 < layout->receiver_rows; k++, row += layout->receiver_columns)
        sum += row[layout->crc_errors] + row[layout->out_of_range];
    for (int64_t k = 0; k < layout->receiver_columns; k++) sum += row[k];
    return sum;
}

int fmi3GetFloat64(void *instance, const uint32_t references[], size_t count, double values[], size_t size)
{
    bool good = count == size;
    for (size_t k = 0; good && k < count; k++) good = number(instance, references[k], &values[k]);
    return good ? OK : complain(instance, "no such number");
}

int fmi3GetInt64(void *instance, const uint32_t references[], size_t count, int64_t values[], size_t size)
{
    const struct antenna *antenna = instance;
    const struct layout *layout = &antenna->layout;
    for (size_t k = 0; k < count; k++) {
        uint32_t reference = references[k];
        if (count != size || reference < SEED || reference > BAD_FRAMES) return complain(antenna, "no such number");
        int64_t place = reference == SEED ? layout->seed_at : reference == STATE ? layout->state_at : layout->fault_at;
        values[k] = reference == BAD_FRAMES ? bad_frames(antenna) : antenna->words[place];
    }
    return OK;
}

int fmi3SetInt64(void *instance, const uint32_t references[], size_t count, const int64_t values[], size_t size)
{
    struct antenna *antenna = instance;
    for (size_t k = 0; k < count; k++) {
        if (count != size || references[k] != SEED || antenna->ticks)
            return complain(antenna, "only the seed can be set, before the first step");
        antenna->words[antenna->layout.seed_at] = values[k] & 0x7FFFFFFF;
    }
    return OK;
}

int fmi3GetBinary(void *instance, const uint32_t references[], size_t count, size_t sizes[], const uint8_t *values[],
                  size_t size)
{
    static const uint8_t nothing;
    struct antenna *antenna = instance;
    for (size_t k = 0; k < count; k++) {
        if (count != size || (references[k] != RX_DATA && references[k] != TX_DATA))
            return complain(antenna, "no such data");
        const struct buffer *data = references[k] == TX_DATA ? &antenna->sent : &antenna->received;
        sizes[k] = data->size, values[k] = data->size ? data->bytes : &nothing;
    }
    return OK;
}

int fmi3SetBinary(void *instance, const uint32_t references[], size_t count, const size_t sizes[],
                  const uint8_t *const values[], size_t size)
{
    struct antenna *antenna = instance;
    for (size_t k = 0; k < count; k++) {
        if (count != size || references[k] != RX_DATA) return complain(antenna, "only Rx_Data can be set");
        antenna->received.size = 0;
        if (!add(&antenna->received, values[k], sizes[k])) return complain(antenna, "out of memory");
    }
    return OK;
}

int fmi3GetClock(void *instance, const uint32_t references[], size_t count, bool values[])
{
    const struct antenna *antenna = instance;
    for (size_t k = 0; k < count; k++) {
        if (references[k] != RX_CLOCK && references[k] != TX_CLOCK) return complain(antenna, "no such clock");
        values[k] = references[k] == TX_CLOCK ? antenna->sending : antenna->received.size > 0;
    }
    return OK;
}

int fmi3SetClock(void *instance, const uint32_t references[], size_t count, const bool values[])
{
    (void)values;
    for (size_t k = 0; k < count; k++)
        if (references[k] != RX_CLOCK) return complain(instance, "only Rx_Clock can be set");
    return OK;
}

/* --- the whole state: antenna, then everything that waits -------------------------------------------------------- */

struct saved {
    size_t size;
    uint8_t bytes[];
};

static struct buffer *waiting(struct antenna *antenna, int which)
{
    struct buffer *all[] = {&antenna->records, &antenna->received, &antenna->sent, &antenna->complaints};
    return all[which];
}

int fmi3FreeFMUState(void *instance, void **state)
{
    (void)instance;
    free(*state), *state = NULL;
    return OK;
}

int fmi3GetFMUState(void *instance, void **state)
{
    struct antenna *antenna = instance;
    struct buffer all = {0};
    double start = antenna->start;
    bool good = add(&all, &antenna->ticks, sizeof antenna->ticks) && add(&all, &start, sizeof start) &&
                add(&all, &antenna->sending, sizeof antenna->sending) &&
                add(&all, antenna->words, (size_t)antenna->layout.words * sizeof(int64_t));
    for (int k = 0; good && k < 4; k++) {
        const struct buffer *one = waiting(antenna, k);
        good = add(&all, &one->size, sizeof one->size) && add(&all, one->bytes, one->size);
    }
    struct saved *saved = good ? malloc(sizeof *saved + all.size) : NULL;
    if (saved) saved->size = all.size, memcpy(saved->bytes, all.bytes, all.size);
    free(all.bytes), free(*state), *state = saved;
    return saved ? OK : complain(antenna, "out of memory");
}

static bool get(const struct saved *saved, size_t *at, void *to, size_t size)
{
    if (size > saved->size - *at) return false;
    if (size) memcpy(to, saved->bytes + *at, size);
    *at += size;
    return true;
}

int fmi3SetFMUState(void *instance, void *state)
{
    struct antenna *antenna = instance;
    const struct saved *saved = state;
    size_t at = 0, size = 0;
    bool good = get(saved, &at, &antenna->ticks, sizeof antenna->ticks) &&
                get(saved, &at, &antenna->start, sizeof antenna->start) &&
                get(saved, &at, &antenna->sending, sizeof antenna->sending) &&
                get(saved, &at, antenna->words, (size_t)antenna->layout.words * sizeof(int64_t));
    for (int k = 0; good && k < 4; k++) {
        struct buffer *one = waiting(antenna, k);
        one->size = 0;
        good = get(saved, &at, &size, sizeof size) && size <= saved->size - at && add(one, saved->bytes + at, size);
        at += good ? size : 0;
    }
    return good ? OK : complain(antenna, "a state of another antenna");
}

int fmi3SerializedFMUStateSize(void *instance, void *state, size_t *size)
{
    (void)instance;
    *size = ((struct saved *)state)->size;
    return OK;
}

int fmi3SerializeFMUState(void *instance, void *state, uint8_t bytes[], size_t size)
{
    const struct saved *saved = state;
    if (size < saved->size) return complain(instance, "too little room for the state");
    memcpy(bytes, saved->bytes, saved->size);
    return OK;
}

int fmi3DeserializeFMUState(void *instance, const uint8_t bytes[], size_t size, void **state)
{
    struct saved *saved = malloc(sizeof *saved + size);
    if (!saved) return complain(instance, "out of memory");
    saved->size = size, memcpy(saved->bytes, bytes, size);
    free(*state), *state = saved;
    return OK;
}

/* --- what this FMU has none of; importers look for each by its name ---------------------------------------------- */

#define NONE(name) \
    int name(void) { return ERROR; }

void *fmi3InstantiateModelExchange(void) { return NULL; }
void *fmi3InstantiateScheduledExecution(void) { return NULL; }
int fmi3EnterConfigurationMode(void *instance) { return instance ? OK : ERROR; }
int fmi3ExitConfigurationMode(void *instance) { return instance ? OK : ERROR; }
int fmi3EvaluateDiscreteStates(void *instance) { return instance ? OK : ERROR; }
NONE(fmi3GetFloat32) NONE(fmi3GetInt8) NONE(fmi3GetUInt8) NONE(fmi3GetInt16) NONE(fmi3GetUInt16) NONE(fmi3GetInt32)
NONE(fmi3GetUInt32) NONE(fmi3GetUInt64) NONE(fmi3GetBoolean) NONE(fmi3GetString) NONE(fmi3SetFloat32)
NONE(fmi3SetFloat64) NONE(fmi3SetInt8) NONE(fmi3SetUInt8) NONE(fmi3SetInt16) NONE(fmi3SetUInt16) NONE(fmi3SetInt32)
NONE(fmi3SetUInt32) NONE(fmi3SetUInt64) NONE(fmi3SetBoolean) NONE(fmi3SetString)
NONE(fmi3GetNumberOfVariableDependencies) NONE(fmi3GetVariableDependencies) NONE(fmi3GetDirectionalDerivative) NONE(fmi3GetAdjointDerivative)
NONE(fmi3GetIntervalDecimal) NONE(fmi3GetIntervalFraction) NONE(fmi3GetShiftDecimal) NONE(fmi3GetShiftFraction)
NONE(fmi3SetIntervalDecimal) NONE(fmi3SetIntervalFraction) NONE(fmi3SetShiftDecimal) NONE(fmi3SetShiftFraction)
NONE(fmi3EnterContinuousTimeMode) NONE(fmi3CompletedIntegratorStep) NONE(fmi3SetTime) NONE(fmi3SetContinuousStates)
NONE(fmi3GetContinuousStateDerivatives) NONE(fmi3GetEventIndicators) NONE(fmi3GetContinuousStates)
NONE(fmi3GetNominalsOfContinuousStates) NONE(fmi3GetNumberOfEventIndicators) NONE(fmi3GetNumberOfContinuousStates)
NONE(fmi3GetOutputDerivatives) NONE(fmi3ActivateModelPartition)
