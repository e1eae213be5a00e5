/* The world around the firmware's own files in the host build.
 *
 * Linked first, so that its data begin the memory that a reset restores. The names of the loop
 * and its parts come from the command line: LOOP, SENSOR, HEATER, perhaps FAN, COOLER, STEPPER,
 * CURRENT, HAS_STATE, and what can be commanded: HOSTED or SWITCHED, TUNABLE, AUTOTUNE,
 * ADJUSTABLE, PROGRAMMED; RELAY is the safety relay's output, RAW the type of the sensor's readings;
 * the firmware's headers are included there, too.
 */
#include "world.h"

#include <avr/eeprom.h>
#include <avr/io.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define JOINED(a, b, c) a##b##c
#define JOIN(a, b, c) JOINED(a, b, c)

#define SETTING(name) settings.JOIN(, LOOP, name)
#define CONTROL JOIN(loop_, LOOP, )
#define GUARD JOIN(guard_, LOOP, )
#define ALGORITHM JOIN(algorithm_, LOOP, )
#define OUTPUT JOIN(output_, HEATER, )
#define EXPERIMENT JOIN(autotune_, LOOP, )
#define MEASURED JOIN(current_, HEATER, )

extern char _end[] __attribute__((visibility("hidden")));

static char first = 1; /* of the memory of the firmware; not 0, for then it would not be in .data */
static char *image;    /* that memory as it is at power-up */
static struct host_world *world;

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

static struct host_input input;

static bool asked; /* for a reading: without being asked, a sensor has none */

uint8_t JOIN(sensor_, SENSOR, _take)(RAW *raw)
{
    const uint8_t status = asked ? input.reading_status : FAULT_SENSOR_STALE;

    asked = false;
    if (status == READING_OK) {
        const RAW reading = (RAW)input.reading_raw;
        memcpy(raw, &reading, sizeof reading);
    }
    return status;
}

void JOIN(sensor_, SENSOR, _begin)(void)
{
    asked = true;
}

void plotter_send(void);
void plotter_send(void)
{
}

void panel_refresh(void);
void panel_refresh(void)
{
}

#ifdef CURRENT
static bool current_asked;

uint8_t JOIN(sensor_, CURRENT, _take)(int16_t *raw)
{
    const uint8_t status = current_asked ? input.current_status : FAULT_SENSOR_STALE;

    current_asked = false;
    if (status == READING_OK) {
        memcpy(raw, &input.current_raw, sizeof *raw);
    }
    return status;
}

void JOIN(sensor_, CURRENT, _begin)(void)
{
    current_asked = true;
}
#endif

uint16_t modbus_silent_ticks(void);
uint16_t modbus_silent_ticks(void)
{
    return input.silent_ticks;
}

#ifdef STEPPER
void JOIN(output_, STEPPER, _halt)(void)
{
    world->feed_halts++;
}
#endif

uint8_t reset_cause;
volatile uint16_t reset_hang_mark;

uint32_t clock_seconds(void);
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
        world->torn = -1; /* nothing is written after that */
    }
    if (world->writes_left > 0) {
        world->writes_left--;
    }
}

/* ---- pins ---- */

uint8_t host_level(uint8_t port)
{
#ifdef FAN
    if (world->fan_stands_still && port == FAN_PORT) {
        return (uint8_t)((host_port[port] & ~FAN_MASK) | FAN_OFF);
    }
#endif
#ifdef CONTACT_PORT
    if (port == CONTACT_PORT) {
        const bool closed = (host_port[RELAY_PORT] & RELAY_MASK) != RELAY_OFF;
        /* Closed to ground while the relay is open, else pulled up. */
        return (uint8_t)(closed ? host_port[port] | CONTACT_MASK : host_port[port] & ~CONTACT_MASK);
    }
#endif
    return host_port[port];
}

#ifdef PWM_INTERRUPT
void PWM_INTERRUPT(void);

/* Counts of one period by which the pin is on: the timer counts, and where it matches, its
 * interrupt comes. */
static uint32_t one_period(void)
{
    uint16_t left = PWM_WHOLE;
    uint32_t on = 0;

    while (left != 0) {
        if (PWM_COUNT == PWM_COMPARE) {
            PWM_INTERRUPT();
        }
        uint16_t run = (uint16_t)(PWM_COMPARE - PWM_COUNT);
        if (run > left) {
            run = left;
        }
        if (JOIN(pin_output_, HEATER, _is_on)()) {
            on += run;
        }
        PWM_COUNT = (uint16_t)(PWM_COUNT + run);
        left = (uint16_t)(left - run);
    }
    return on;
}
#endif

uint32_t host_heater(void)
{
    const bool on = JOIN(pin_output_, HEATER, _is_on)();

#ifdef PWM_INTERRUPT
    if (PWM_ENABLED) {
        return one_period();
    }
    return on ? PWM_WHOLE : 0;
#elif defined(PWM_BITS)
    if (PWM_CONTROL & PWM_BITS) {
        return PWM_COMPARE + 1u;
    }
    return on ? PWM_WHOLE : 0;
#else
    return on ? 1 : 0;
#endif
}

/* ---- the firmware's life ---- */

void host_power_up(void)
{
    memcpy(&first, image, (size_t)(_end - &first));
    world->ticks = 0;
    world->heater_counts = 0;
#ifdef CURRENT
    current_asked = true; /* the first codes come by themselves */
#endif
    for (uint8_t i = 0; i < HOST_PORTS; i++) {
        host_ddr[i] = 0xFF;
    }
    JOIN(pin_output_, HEATER, _off)(); /* as reset.c does */
#ifdef COOLER
    world->cooler_ticks = 0;
    world->both_on = 0;
    JOIN(pin_output_, COOLER, _off)();
#endif
#ifdef RELAY
    JOIN(pin_output_, RELAY, _off)();
#endif
    settings_start();
#ifdef CONTACT_PORT
    relay_start();
#endif
#ifdef PROGRAMMED
    progress_start();
#endif
#ifdef FAN
    JOIN(output_, FAN, _start)();
#endif
#ifdef PWM_WHOLE
    JOIN(output_, HEATER, _start)();
#endif
    JOIN(guard_, LOOP, _reset)();
#ifdef PROGRAMMED
    program_start_up();
#endif
    JOIN(loop_, LOOP, _start)();
}

static void store(void)
{
    settings_tick();
#ifdef PROGRAMMED
    progress_tick();
    programs_tick();
#endif
}

void host_tick(void)
{
    world->ticks++;
    gate_tick();
    world->heater_counts += host_heater();
#ifdef COOLER
    const bool cools = JOIN(pin_output_, COOLER, _is_on)();
    world->cooler_ticks += cools;
    world->both_on += cools && host_heater() != 0;
#endif
    if (world->main_hangs) {
        return;
    }
    gate_renew_main();
    if (!world->loop_hangs) {
        JOIN(loop_, LOOP, _tick)();
    }
    store();
}

/* False if the firmware refuses it. */
static bool command(const struct host_input *asked)
{
    switch (asked->command) {
#if defined(HOSTED) || defined(SWITCHED)
    case HOST_SET:
        return JOIN(loop_, LOOP, _set)(asked->value);
#endif
#ifdef SWITCHED
    case HOST_ENABLE:
        return JOIN(loop_, LOOP, _enable)();
    case HOST_DISABLE:
        JOIN(loop_, LOOP, _disable)();
        break;
#endif
#if defined(SWITCHED) && defined(TUNABLE)
    case HOST_PERCENT:
        return JOIN(loop_, LOOP, _set_manual_percent)(asked->value);
    case HOST_AUTOMATIC:
        JOIN(loop_, LOOP, _set_automatic)();
        break;
#endif
#ifdef HOSTED
    case HOST_EMERGENCY:
        fault_trip(FAULT_EMERGENCY_STOP, 0.0f);
        break;
#endif
#ifdef TUNABLE
    case HOST_MANUAL:
        return JOIN(loop_, LOOP, _set_manual)(asked->value);
    case HOST_GAINS:
        SETTING(_kp) = asked->gains[0];
        SETTING(_ki) = asked->gains[1];
        SETTING(_kd) = asked->gains[2];
        break;
    case HOST_KEEP:
        settings_keep();
        break;
    case HOST_RELOAD:
        settings_reload();
        break;
    case HOST_DEFAULTS:
        settings_defaults();
        break;
#endif
#ifdef AUTOTUNE
    case HOST_TUNE:
        return JOIN(loop_, LOOP, _tune)(asked->value, (uint8_t)asked->gains[0]);
    case HOST_STOP_TUNING:
        JOIN(loop_, LOOP, _stop_tuning)();
        break;
#endif
#ifdef ADJUSTABLE
    case HOST_MAXIMUM:
        return JOIN(guard_, LOOP, _set_maximum)(asked->value);
#endif
    default:
        break;
    }
    return true;
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

void host_set(const struct host_input *next)
{
    input = *next;
#if !defined(HOSTED) && !defined(SWITCHED)
    SETTING(_setpoint_c) = input.setpoint_c;
#endif
    if (input.acknowledge) {
        fault_acknowledge();
    }
    world->refused = !command(&input);
#ifdef PROGRAMMED
    world->order_refused = !order(&input);
#endif
}

static uint8_t *put(uint8_t *to, const void *from, size_t size)
{
    memcpy(to, from, size);
    return to + size;
}

uint32_t host_state(uint8_t *to)
{
    uint8_t *end = put(to, &CONTROL, sizeof CONTROL);

    end = put(end, &GUARD, sizeof GUARD);
    end = put(end, &ALGORITHM, sizeof ALGORITHM);
    end = put(end, &fault, sizeof fault);
#ifdef HAS_STATE
    end = put(end, &OUTPUT, sizeof OUTPUT);
#endif
#ifdef AUTOTUNE
    end = put(end, &EXPERIMENT, sizeof EXPERIMENT);
#endif
#ifdef CURRENT
    end = put(end, &MEASURED, sizeof MEASURED);
#endif
#ifdef PROGRAMMED
    end = put(end, &program, sizeof program);
#endif
#ifdef HOSTED
    *end++ = JOIN(loop_, LOOP, _is_ready)();
#endif
#ifdef SWITCHED
    *end++ = JOIN(loop_, LOOP, _state)();
#endif
    return (uint32_t)(end - to);
}

/* False if the step does not come. */
static bool run_to_step(void)
{
    const uint16_t before = CONTROL.steps;

    for (uint32_t i = 0; i < 2u * PERIOD_TICKS; i++) {
        host_tick();
        if (CONTROL.steps != before) {
            return true;
        }
    }
    return false;
}

uint32_t host_run(const struct host_input *inputs, uint32_t steps, uint8_t *states, uint32_t *counts)
{
    for (uint32_t i = 0; i < steps; i++) {
        host_set(&inputs[i]);
        if (!run_to_step()) {
            return i;
        }
        states += host_state(states);
        counts[i] = world->heater_counts;
    }
    return steps;
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
