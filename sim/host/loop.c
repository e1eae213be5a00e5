/* One loop of the host build: its sensors, its pins, and its commands.
 *
 * Compiled once for each loop. The command line includes the firmware's headers, and defines the
 * names of the loop and its parts: LOOP, SENSOR, HEATER; if any, FAN, COOLER, CURRENT, HAS_STATE; for
 * commands HOSTED or SWITCHED, TUNABLE, AUTOTUNE, ADJUSTABLE, LIMITS, PROGRAMMED; NUMBERS that keys
 * set; MONITORS and MONITORED, their sensors and names; RAW, the type of the sensor's readings.
 */
#include "world.h"

#include <avr/io.h>
#include <stdbool.h>
#include <string.h>

#define SELF JOIN(host_loop_, LOOP, )
#define SETTING(name) settings.JOIN(, LOOP, name)
#define CONTROL JOIN(loop_, LOOP, )
#define GUARD JOIN(guard_, LOOP, )
#define ALGORITHM JOIN(algorithm_, LOOP, )
#define OUTPUT JOIN(output_, HEATER, )
#define EXPERIMENT JOIN(autotune_, LOOP, )
#define MEASURED JOIN(current_, HEATER, )

extern struct host_loop SELF;

/* ---- sensors ---- */

static bool asked; /* whether a reading was requested: without a request there is no reading */

uint8_t JOIN(sensor_, SENSOR, _take)(RAW *raw)
{
    const uint8_t status = asked ? SELF.input.reading_status : FAULT_SENSOR_STALE;

    asked = false;
    if (status == READING_OK) {
        const RAW reading = (RAW)SELF.input.reading_raw;
        memcpy(raw, &reading, sizeof reading);
    }
    return status;
}

void JOIN(sensor_, SENSOR, _begin)(void)
{
    asked = true;
}

#ifdef CURRENT
static bool current_asked;

uint8_t JOIN(sensor_, CURRENT, _take)(int16_t *raw)
{
    const uint8_t status = current_asked ? SELF.input.current_status : FAULT_SENSOR_STALE;

    current_asked = false;
    if (status == READING_OK) {
        memcpy(raw, &SELF.input.current_raw, sizeof *raw);
    }
    return status;
}

void JOIN(sensor_, CURRENT, _begin)(void)
{
    current_asked = true;
}
#endif

#ifdef MONITORS
/* For each monitor: its sensor, the type of its readings, and its possible readings. */
#define MONITOR(NAME, NUMBER, TYPE, ...)                                                           \
    static bool JOIN(NAME, _asked, );                                                              \
    uint8_t JOIN(sensor_, NAME, _take)(TYPE *raw)                                                  \
    {                                                                                              \
        static const TYPE readings[HOST_READINGS] = { __VA_ARGS__ };                               \
        const uint8_t only = SELF.input.monitored / HOST_ONLY;                                     \
        const bool is_meant = only == 0 || only == (NUMBER);                                       \
        const uint8_t given = is_meant ? SELF.input.monitored % HOST_ONLY : 0;                     \
        const bool was_asked = JOIN(NAME, _asked, );                                               \
        JOIN(NAME, _asked, ) = false;                                                              \
        if (!was_asked) {                                                                          \
            return FAULT_SENSOR_STALE;                                                             \
        }                                                                                          \
        if (given < HOST_READINGS) {                                                               \
            memcpy(raw, &readings[given], sizeof *raw);                                            \
            return READING_OK;                                                                     \
        }                                                                                          \
        return (uint8_t)(given - HOST_BAD);                                                        \
    }                                                                                              \
    void JOIN(sensor_, NAME, _begin)(void)                                                         \
    {                                                                                              \
        JOIN(NAME, _asked, ) = true;                                                               \
    }
MONITORS
#undef MONITOR
#endif

/* ---- pins ---- */

#ifdef PWM_INTERRUPT
void PWM_INTERRUPT(void);

static bool pulses;
static uint16_t count; /* the timer's count for this output: other outputs may have other periods */

/* Returns the counts of one period for which the pin is on: the timer counts, and its interrupt
 * comes at each match. */
static uint32_t one_period(void)
{
    const uint16_t others_count = PWM_COUNT;
    uint16_t left = PWM_WHOLE;
    uint32_t on = 0;

    if (pulses) {
        PWM_COUNT = count;
    }
    pulses = true;
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
    count = PWM_COUNT;
    PWM_COUNT = others_count;
    return on;
}
#endif

static uint32_t heater(void)
{
    const bool on = JOIN(pin_output_, HEATER, _is_on)();

#ifdef PWM_INTERRUPT
    if (PWM_ENABLED) {
        return one_period();
    }
    pulses = false;
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

static bool cools(void)
{
#ifdef COOLER
    return JOIN(pin_output_, COOLER, _is_on)();
#else
    return false;
#endif
}

static void off(void)
{
    JOIN(pin_output_, HEATER, _off)();
#ifdef COOLER
    JOIN(pin_output_, COOLER, _off)();
#endif
}

static void start(void)
{
#ifdef CURRENT
    current_asked = true; /* the first codes come without a request */
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
#ifdef MONITORS
#define MONITOR(NAME, ...) JOIN(sensor_, NAME, _begin)();
    MONITORS
#undef MONITOR
#endif
    JOIN(loop_, LOOP, _start)();
}

static void tick(void)
{
#ifdef PWM_INTERRUPT
    if (pulses) {
        PWM_COUNT = count; /* so that pulses begin at any count */
    }
#endif
    JOIN(loop_, LOOP, _tick)();
}

/* Returns false if the firmware refuses the command. */
static bool command(const struct host_input *asked)
{
#if !defined(HOSTED) && !defined(SWITCHED)
    SETTING(_setpoint_c) = asked->setpoint_c;
    settings_seal();
#endif
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
#ifdef LIMITS
    case HOST_LIMITS:
        if (!JOIN(settings_may_limit_, LOOP, )(asked->gains[0], asked->gains[1], asked->gains[2])) {
            return false;
        }
        SETTING(_integral_minimum_percent) = asked->gains[0];
        SETTING(_integral_maximum_percent) = asked->gains[1];
        SETTING(_output_maximum_percent) = asked->gains[2];
        break;
#endif
#ifdef AUTOTUNE
    case HOST_TUNE:
        return JOIN(loop_, LOOP, _tune)(asked->value, (uint8_t)asked->gains[0]);
    case HOST_STOP_TUNING:
        JOIN(loop_, LOOP, _stop_tuning)();
        break;
#endif
#ifdef NUMBERS
    case HOST_NUMBERS: {
        const float *next = asked->gains;
#define NUMBER(MEMBER) SETTING(_##MEMBER) = *next++;
        NUMBERS
#undef NUMBER
        break;
    }
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

static uint8_t *put(uint8_t *to, const void *from, size_t size)
{
    memcpy(to, from, size);
    return to + size;
}

static uint32_t state(uint8_t *to)
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
#ifdef RESPONSE
    end = put(end, &JOIN(response_, LOOP, ), sizeof JOIN(response_, LOOP, ));
#endif
#ifdef MONITORED
#define MONITOR(NAME) end = put(end, &JOIN(monitor_, NAME, ), sizeof JOIN(monitor_, NAME, ));
    MONITORED
#undef MONITOR
#endif
#ifdef HOSTED
    *end++ = JOIN(loop_, LOOP, _is_ready)();
#endif
#ifdef SWITCHED
    *end++ = JOIN(loop_, LOOP, _state)();
#endif
    return (uint32_t)(end - to);
}

struct host_loop SELF = {
    .off = off,
    .start = start,
    .tick = tick,
    .command = command,
    .heater = heater,
    .cools = cools,
    .state = state,
    .steps = &CONTROL.steps,
    .period_ticks = PERIOD_TICKS,
#ifdef FAN
    .fan_port = FAN_PORT,
    .fan_mask = FAN_MASK,
    .fan_off = FAN_OFF,
#else
    .fan_port = HOST_PORTS, /* none */
#endif
};
