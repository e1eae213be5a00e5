/* Replaces the hardware around the firmware's own files in the host build, for all loops.
 *
 * Linked first, so that its data is at the start of the memory that a reset restores. The command
 * line includes the firmware's headers, and defines names: LOOPS has LOOP(name) for each loop, in the
 * order of the spec. These are defined only if the machine has the part: STEPPER, RELAY, CONTACT (the
 * relay's mirror contact), PROGRAMMED, PROOFS, COUNTED (the proofs by tachometer), INPUTS.
 */
#include "world.h"

#include <avr/eeprom.h>
#include <avr/io.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define LOOP(name) extern struct host_loop host_loop_##name;
LOOPS
#undef LOOP
#define LOOP(name) &host_loop_##name,
static struct host_loop *const loops[] = {LOOPS};
enum { LOOP_COUNT = sizeof loops / sizeof *loops };

extern char _end[] __attribute__((visibility("hidden")));

static char first = 1; /* first byte of the firmware's memory; not 0, so that it is in .data */
static char *image;    /* a copy of that memory at power-up */
static struct host_world *world;
static struct host_course *courses; /* those that run now, one for each loop */
static const struct host_loop *ticking;

volatile uint8_t host_port[HOST_PORTS];
volatile uint8_t host_ddr[HOST_PORTS];
volatile struct host_timer host_timer[HOST_TIMERS];

__attribute__((constructor)) static void keep_image(void)
{
    const size_t size = (size_t)(_end - &first);

    world = calloc(1, sizeof *world);
    world->writes_left = -1;
    image = malloc(size);
    memcpy(image, &first, size);
}

struct host_world *host_world(void)
{
    return world;
}

/* ---- the files that are not under test ---- */

void plotter_send(void)
{
}

void panel_refresh(void)
{
}

uint16_t modbus_silent_ticks(void)
{
    return ticking->input.silent_ticks;
}

uint16_t gcode_silent_ticks(void)
{
    return ticking->input.silent_ticks;
}

#ifdef STEPPER
void JOIN(output_, STEPPER, _halt)(void)
{
    world->feed_halts++;
}
#endif

uint8_t reset_cause;
volatile uint16_t reset_hang_mark;
#ifdef LOCKOUT_WAIT_S
uint16_t reset_power_mark;
#endif

uint32_t clock_seconds(void)
{
    return world->ticks / 100u;
}

/* ---- EEPROM ---- */

static bool is_inside(uintptr_t place)
{
    if (place < world->eeprom_bytes) {
        return true;
    }
    world->eeprom_outside++;
    return false;
}

bool eeprom_is_ready(void)
{
    return true;
}

uint8_t eeprom_read_byte(const uint8_t *place)
{
    return is_inside((uintptr_t)place) ? world->eeprom[(uintptr_t)place] : 0;
}

void eeprom_read_block(void *to, const void *from, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        ((uint8_t *)to)[i] = eeprom_read_byte((const uint8_t *)((uintptr_t)from + i));
    }
}

void eeprom_write_byte(uint8_t *place, uint8_t value)
{
    if (!is_inside((uintptr_t)place)) {
        return;
    }
    world->eeprom_writes++;
    if (world->writes_left != 0) {
        world->eeprom[(uintptr_t)place] = value;
    } else if (world->torn >= 0) {
        world->eeprom[(uintptr_t)place] = (uint8_t)world->torn;
        world->torn = -1; /* nothing is written after the power failure */
    }
    if (world->writes_left > 0) {
        world->writes_left--;
    }
}

/* ---- pins ---- */

#ifdef PROOFS
/* Returns whether a line with a pull-up is held to ground. A pulse is high in its second half; one of
 * odd length is low for one read longer. */
static bool is_grounded(uint16_t healthy)
{
    const uint16_t line = world->proof_line == HOST_PROVES ? healthy : world->proof_line;

    if (line <= HOST_SHORTED) {
        return line == HOST_SHORTED;
    }
    return world->looks % line < (line + 1u) / 2u;
}
#endif

uint8_t host_level(uint8_t port)
{
    uint8_t level = host_port[port];

    for (uint8_t i = 0; i < LOOP_COUNT; i++) {
        const struct host_loop *loop = loops[i];
        if (world->fan_stands_still && port == loop->fan_port) {
            level = (uint8_t)((level & ~loop->fan_mask) | loop->fan_off);
        }
    }
#ifdef CONTACT_PORT
    if (port == CONTACT_PORT) {
        const bool closed = (host_port[RELAY_PORT] & RELAY_MASK) != RELAY_OFF;
        /* Closed to ground while the relay is open, otherwise pulled up. */
        level = (uint8_t)(closed ? level | CONTACT_MASK : level & ~CONTACT_MASK);
    }
#endif
#ifdef PROOFS
#define PROOF(NAME, PORT, MASK, HEALTHY)                                                           \
    if (port == (PORT) && is_grounded(HEALTHY)) {                                                  \
        level = (uint8_t)(level & ~(MASK));                                                        \
    }
    PROOFS
#undef PROOF
#endif
#ifdef INPUTS
#define INPUT(NUMBER, PORT, MASK)                                                                  \
    if (port == (PORT)) { /* closed to ground, else pulled up, if it is an input with a pull-up */ \
        const bool open = world->open_inputs & (1u << (NUMBER));                                   \
        const bool lifted = host_port[port] & ~host_ddr[port] & (MASK);                            \
        level = (uint8_t)(open && lifted ? level | (MASK) : level & ~(MASK));                      \
    }
    INPUTS
#undef INPUT
#endif
    return level;
}

/* ---- power-up, ticks, commands ---- */

/* The clock's interrupts within a tick, without the gate. */
static void look_at_lines(void)
{
    for (uint8_t i = 0; i < LOOKS; i++) {
        world->looks++;
#ifdef COUNTED
#define PROOF(NAME, WINDOW) JOIN(proof_, NAME, _sample)();
        COUNTED
#undef PROOF
#endif
    }
}

/* Start the proofs as if pulses had been counted for a whole window. */
static void begin_proofs(void)
{
    world->looks = 0;
#ifdef PROOFS
#define PROOF(NAME, ...) JOIN(proof_, NAME, _start)();
    PROOFS
#undef PROOF
#endif
#ifdef COUNTED
#define PROOF(NAME, WINDOW)                                                                        \
    for (uint8_t i = 0; i < (WINDOW); i++) {                                                       \
        look_at_lines();                                                                           \
    }
    COUNTED
#undef PROOF
#endif
}

void host_power_up(void)
{
    memcpy(&first, image, (size_t)(_end - &first));
    ticking = loops[0];
    world->ticks = 0;
    world->heater_counts = 0;
    world->cooler_ticks = 0;
    world->both_on = 0;
    for (uint8_t i = 0; i < HOST_PORTS; i++) {
        host_ddr[i] = 0xFF;
    }
    for (uint8_t i = 0; i < LOOP_COUNT; i++) {
        loops[i]->off(); /* as reset.c does */
    }
#ifdef RELAY
    JOIN(pin_output_, RELAY, _off)();
#endif
    settings_start();
    begin_proofs();
    world->open_inputs = 0;
#ifdef INPUTS
    inputs_start();
#endif
#ifdef CONTACT_PORT
    relay_start();
#endif
#ifdef PROGRAMMED
    progress_start();
#endif
    for (uint8_t i = 0; i < LOOP_COUNT; i++) {
        loops[i]->start();
    }
}

static void store(void)
{
#ifdef LOCKOUT_TRIPS
    fault_tick();
#endif
    settings_tick();
#ifdef PROGRAMMED
    progress_tick();
    programs_tick();
#endif
}

static void look_at_pins(struct host_loop *loop)
{
    const uint32_t counts = loop->heater();
    const bool cools = loop->cools();

    loop->heater_counts += counts;
    world->heater_counts += counts;
    world->cooler_ticks += cools;
    world->both_on += cools && counts != 0;
}

/* Record the state after a loop's step, before the next loop's step. */
static void note(const struct host_loop *loop, struct host_course *course)
{
    course->waited_ticks = 0;
    if (course->done == course->steps) {
        return;
    }
    course->states += loop->state(course->states);
    course->counts[course->done] = loop->heater_counts;
    course->done++;
}

void host_tick(void)
{
    world->ticks++;
    look_at_lines();
    gate_tick();
    for (uint8_t i = 0; i < LOOP_COUNT; i++) {
        look_at_pins(loops[i]);
    }
#ifdef INPUTS
#define INPUT(NUMBER, PORT, MASK)                                                                  \
    if (world->pull_ups_flip) {                                                                    \
        host_port[PORT] &= (uint8_t)~(MASK);                                                       \
        host_ddr[PORT] |= (MASK);                                                                  \
    }
    INPUTS
#undef INPUT
#endif
    if (world->main_hangs) {
        return;
    }
    gate_renew_main();
#ifdef PROOFS
#define PROOF(NAME, ...) JOIN(proof_, NAME, _tick)();
    PROOFS
#undef PROOF
#endif
#ifdef INPUTS
    inputs_tick();
#endif
    for (uint8_t i = 0; i < LOOP_COUNT && !world->loop_hangs; i++) {
        const uint16_t before = *loops[i]->steps;
        ticking = loops[i];
        ticking->tick();
        if (courses != NULL && *ticking->steps != before) {
            note(ticking, &courses[i]);
        }
    }
    store();
}

#ifdef PROGRAMMED
static bool order(const struct host_input *asked)
{
    switch (asked->order) {
    case PROGRAM_STOP:
        return program_stop();
    case PROGRAM_PAUSE:
        return program_pause();
    case PROGRAM_START:
        return program_start(asked->argument);
    case PROGRAM_RESUME:
        return program_resume();
    case PROGRAM_SKIP:
        return program_skip();
    case PROGRAM_JUMP:
        return program_jump(asked->argument);
    default:
        return true;
    }
}
#endif

void host_acknowledge(void)
{
#ifdef LOCKOUT_TRIPS
    fault.trips = 0;
#endif
    fault_acknowledge();
}

void host_set(uint8_t loop, const struct host_input *next)
{
    loops[loop]->input = *next;
    if (loop == 0) {
        world->open_inputs = next->open_inputs;
    }
    if (next->acknowledge) {
        host_acknowledge();
    }
    world->refused = !loops[loop]->command(next);
#ifdef PROGRAMMED
    world->order_refused = !order(next);
#endif
}

uint32_t host_state(uint8_t loop, uint8_t *to)
{
    return loops[loop]->state(to);
}

/* Returns whether any course is not done. Each course continues with its next input after all loops
 * have run in the tick. */
static bool go_on(void)
{
    bool left = false;

    for (uint8_t i = 0; i < LOOP_COUNT; i++) {
        struct host_course *course = &courses[i];
        if (course->waited_ticks == 0 && course->done != course->steps) {
            host_set(i, &course->inputs[course->done]);
        }
        course->waited_ticks++;
        if (course->done != course->steps) {
            left = true;
            if (course->waited_ticks > 2u * loops[i]->period_ticks) {
                return false; /* the expected step did not come */
            }
        }
    }
    return left;
}

void host_run(struct host_course *all)
{
    courses = all;
    while (go_on()) {
        host_tick();
    }
    courses = NULL;
}

void host_settle(void)
{
    for (uint16_t i = 0; i < 1000; i++) {
        const uint32_t before = world->eeprom_writes;
        store();
        store();
        if (world->eeprom_writes == before) {
            return;
        }
    }
}
