/* A plant with weather, mains and a sensor about the host build: a year takes a minute. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#pragma pack(1) /* as the host build has it */
#include "world.h"
#pragma pack()

#include "year.h"

enum { PAST = 64, A_MINUTE = 60 };

static const double DAY_S = 86400.0, YEAR_S = 365.0 * 86400.0, TURN = 2.0 * 3.14159265358979;

static uint64_t random_state;
static int32_t place; /* of the last code: edges below it; the next one is near */
static double load; /* of others on the mains, -0.5 to 0.5 */

/* S. Vigna, "An experimental exploration of Marsaglia's xorshift generators" (2016). */
static uint32_t random_32(void)
{
    random_state ^= random_state >> 12;
    random_state ^= random_state << 25;
    random_state ^= random_state >> 27;
    return (uint32_t)((random_state * 2685821657736338717u) >> 32);
}

/* Mains: a day's swing, and steps as others switch their loads. */
static double supply(const struct year_machine *machine, double swing)
{
    if (random_32() % 1024u == 0) {
        load = (double)random_32() / 4294967296.0 - 0.5;
    }
    return 1.0 + machine->supply * (load + 0.5 * swing);
}

static double outside_c(const struct year_machine *machine, double time_s)
{
    return machine->ambient_c + machine->day_k * sin(TURN * time_s / DAY_S)
        + machine->season_k * sin(TURN * time_s / YEAR_S);
}

static int32_t code_of(const struct year_machine *machine, double felt_c)
{
    while (place < machine->codes && machine->edges_c[place] <= felt_c) {
        place++;
    }
    while (place > 0 && machine->edges_c[place - 1] > felt_c) {
        place--;
    }
    return machine->lowest_code + machine->code_step * place;
}

/* Two draws from a table that the processor's cache holds: what they sum up to is normal, too. */
static int32_t reading(const struct year_machine *machine, double felt_c)
{
    int32_t sum = 0;

    for (uint32_t i = 0; i < machine->oversample; i++) {
        const uint32_t draw = random_32();
        const double noise = machine->normals[draw >> 22] + machine->normals[draw >> 12 & 1023u];
        sum += code_of(machine, felt_c + machine->noise_k * noise);
    }
    return sum;
}

static float member(const uint8_t *state, uint32_t at)
{
    float value;

    memcpy(&value, state + at, sizeof value);
    return value;
}

/* One period. */
static void go_on(const struct year_machine *machine, double *x, double power_w, bool cools)
{
    const uint32_t size = machine->states;
    double next[YEAR_STATES];

    x[size] = power_w;
    for (uint32_t i = 0; i < size; i++) {
        next[i] = 0.0;
        for (uint32_t j = 0; j < size + 2u; j++) {
            next[i] += machine->step[cools][i][j] * x[j];
        }
    }
    memcpy(x, next, size * sizeof *x);
}

void year(const struct year_machine *machine, float setpoint_c, uint64_t steps, uint64_t settled,
          uint64_t seed, uint32_t kept, struct host_input *inputs, struct year_told *told)
{
    double x[YEAR_INPUTS], past[PAST], weather_c = 0.0, mains = 0.0;
    struct host_input input = {0};
    uint8_t state[1024];
    const uint32_t whole = (uint32_t)machine->late_steps;
    const double part = machine->late_steps - whole;

    random_state = seed;
    place = 0;
    load = 0.0;
    for (uint32_t i = 0; i < YEAR_INPUTS; i++) {
        x[i] = outside_c(machine, machine->start_s);
    }
    for (uint32_t i = 0; i < PAST; i++) {
        past[i] = x[0];
    }
    told->least_c = INFINITY;
    told->most_c = -INFINITY;
    input.setpoint_c = setpoint_c;
    for (uint64_t i = 0; i < steps; i++) {
        const double time_s = machine->start_s + (double)i * machine->period_s;
        if (i % A_MINUTE == 0) {
            weather_c = outside_c(machine, time_s);
            mains = sin(TURN * 2.0 * time_s / DAY_S);
        }
        const double volts = supply(machine, mains);
        past[i % PAST] = x[machine->felt];
        const double felt_c = (1.0 - part) * past[(i - whole) % PAST]
            + part * past[(i - whole - 1u) % PAST];
        input.reading_raw = reading(machine, felt_c);
        if (i < kept) {
            inputs[i] = input;
        }
        machine->set(0, &input);
        for (uint32_t tick = 0; tick < machine->period_ticks; tick++) {
            machine->tick();
        }
        machine->state(0, state);
        told->steps = i + 1u;
        told->fault = state[machine->fault_at];
        if (told->fault != 0) {
            return;
        }
        const double duty = (double)member(state, machine->duty_at) / 100.0;
        const bool cools = machine->cooling_at != 0 && state[machine->cooling_at] != 0;
        x[machine->states + 1u] = weather_c;
        go_on(machine, x, duty * machine->full_w * volts * volts, cools);
        if (i >= settled) {
            told->least_c = fmin(told->least_c, felt_c);
            told->most_c = fmax(told->most_c, felt_c);
        }
    }
}
