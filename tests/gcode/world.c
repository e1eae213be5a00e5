/* The world around the generated G-code files, on this computer: a serial line, tools, a fan, a feed.
 *
 * Standard input holds commands of one letter: 'r', a count (16 bits) and bytes to receive; 'x',
 * the receiver's flags and a byte; 't', a count (16 bits) of ticks; 'c' and 'b', the temperature of
 * nozzle and bed (a float), 's', the nozzle's setpoint by somebody else; 'f', a
 * fault's code, 'k', a key that acknowledges it, 'a', a tuning's result, and 'w', how often its relay has
 * switched (8 bits each).
 * What is sent goes to standard output; `=` lines show the state at the end.
 */
#include <math.h>

#include "script.h"

#include "autotune_nozzle.h"
#include "config.h"
#include "fault.h"
#include "gcode.h"
#include "loop_nozzle.h"
#include "settings.h"

#ifdef __AVR_ATmega328P__ /* it has but one */
#define USART0_RX_vect USART_RX_vect
#define USART0_UDRE_vect USART_UDRE_vect
#endif
void USART0_RX_vect(void);
void USART0_UDRE_vect(void);

/* Ten bits a byte, at eight cycles of the divisor a bit. */
enum { BYTES_SENT_PER_TICK = F_CPU / 8000 / (HOST_DIVISOR + 1) };

struct fault_state fault;
struct settings settings;
struct loop_nozzle_state loop_nozzle;
struct autotune_nozzle_state autotune_nozzle;
static float fan_percent;
static unsigned acknowledgements, kept, reloaded, defaulted, cycles_asked;

void fault_trip(uint8_t code, float temperature_c)
{
    if (fault.code == FAULT_NONE) {
        fault.code = code;
        fault.temperature_c = temperature_c;
    }
}

bool fault_is_locked(void) { return fault.trips >= LOCKOUT_TRIPS; }

void fault_acknowledge(void)
{
    if (fault.code != FAULT_NONE) {
        fault.code = FAULT_NONE;
        acknowledgements++;
        settings.nozzle_setpoint_c = 0.0f;
    }
}

/* What is alike for every loop. */
#define TAKES_A_SETPOINT(name, NAME)                                                           \
    bool loop_##name##_set(float setpoint_c)                                                   \
    {                                                                                          \
        if (setpoint_c != 0.0f                                                                 \
            && (fault.code != FAULT_NONE || !(setpoint_c >= LOOP_##NAME##_SETPOINT_MINIMUM_C)  \
                || setpoint_c > LOOP_##NAME##_SETPOINT_MAXIMUM_C)) {                           \
            return false;                                                                      \
        }                                                                                      \
        settings.name##_setpoint_c = setpoint_c;                                               \
        return true;                                                                           \
    }                                                                                          \
    bool loop_##name##_is_ready(void)                                                          \
    {                                                                                          \
        return fault.code == FAULT_NONE && settings.name##_setpoint_c != 0.0f                  \
            && fabsf(settings.name##_setpoint_c - loop_##name.temperature_c) <= 1.0f;          \
    }

TAKES_A_SETPOINT(nozzle, NOZZLE)

#if __has_include("loop_bed.h")
#include "loop_bed.h"
struct loop_bed_state loop_bed;
TAKES_A_SETPOINT(bed, BED)
#define BED_C loop_bed.temperature_c
static void heat_bed(void)
{
    loop_bed.duty_percent = settings.bed_setpoint_c > loop_bed.temperature_c ? 100.0f : 0.0f;
}
#else
#define BED_C loop_nozzle.temperature_c
static void heat_bed(void) { }
#endif

#if __has_include("loop_spare.h") /* another tool, of which no more is looked at */
#include "loop_spare.h"
struct loop_spare_state loop_spare = { .temperature_c = 40.4f };
TAKES_A_SETPOINT(spare, SPARE)
bool loop_spare_set_manual(float percent)
{
    loop_spare.duty_percent = percent;
    return true;
}
#endif

bool loop_nozzle_set_manual(float percent)
{
    if (fault.code != FAULT_NONE || !(percent >= 0.0f) || percent > 100.0f) {
        return false;
    }
    loop_nozzle.manual_percent = loop_nozzle.duty_percent = percent;
    loop_nozzle.mode = 1;
    return true;
}

/* The experiment itself is not here: the world says how it goes and ends. */
bool loop_nozzle_tune(float target_c, uint8_t cycles)
{
    if (target_c == 0.0f || cycles < 1 || !loop_nozzle_set(target_c)) {
        return false;
    }
    autotune_nozzle.result = 1;
    autotune_nozzle.switches = 0;
    cycles_asked = cycles;
    return true;
}

void loop_nozzle_stop_tuning(void)
{
    autotune_nozzle.result = 4;
    settings.nozzle_setpoint_c = 0.0f;
}

void output_fan_set(float percent);
void output_fan_set(float percent) { fan_percent = percent; }
void output_part_fan_set(float percent);
void output_part_fan_set(float percent) { fan_percent = percent; }

/* ---- the feed: it runs while the nozzle is ready, and brakes for a few steps ---- */

static int32_t feed_is_at, feed_ends_at;
static unsigned disabled;

#if __has_include("output_feed.h")
#include "output_feed.h"

enum { BRAKING_STEPS = 200 }; /* several ticks; in one of them the feed is where G1 wants it */

static float steps_per_tick;
static bool braking;

void output_feed_move(int32_t steps, float mm_per_s)
{
    const int32_t left = feed_ends_at - feed_is_at;

    must(steps != 0 && fault.code == FAULT_NONE, "a move of no steps, or while a fault is latched");
    must(left == 0 || (left < 0) == (steps < 0), "a move that turns round while the feed is busy");
    must(mm_per_s > 0.0f && mm_per_s <= OUTPUT_FEED_MAXIMUM_MM_PER_S,
        "a speed that is none, or too high");
    must(!braking || left == 0, "a move while the feed slows down");
    braking = false;
    disabled = 0;
    feed_ends_at += steps;
    steps_per_tick = mm_per_s * OUTPUT_FEED_STEPS_PER_MM / 100.0f;
}

bool output_feed_is_busy(void) { return feed_is_at != feed_ends_at; }

int32_t output_feed_position(void) { return feed_is_at; }

void output_feed_stop(void)
{
    const int32_t left = feed_ends_at - feed_is_at;

    braking = left != 0;
    if (abs(left) > BRAKING_STEPS) {
        feed_ends_at = feed_is_at + (left < 0 ? -BRAKING_STEPS : BRAKING_STEPS);
    }
}

void output_feed_disable(void)
{
    feed_ends_at = feed_is_at;
    disabled++;
}

static void feed_tick(void)
{
    static float share;
    const int32_t left = feed_ends_at - feed_is_at;

    if (left == 0 || fault.code != FAULT_NONE) {
        feed_ends_at = feed_is_at;
        braking = false;
        return;
    }
    if (!braking && !loop_nozzle_is_ready()) {
        return;
    }
    share += steps_per_tick;
    const int32_t most = (int32_t)share;
    share -= (float)most;
    feed_is_at += left < 0 ? (left < -most ? -most : left) : (left > most ? most : left);
}
#else
static void feed_tick(void) { }
#endif

#ifdef LOOP_NOZZLE_OUTPUT_LEAST_MAXIMUM
bool settings_may_limit_nozzle(float integral_minimum, float integral_maximum, float output_maximum)
{
    return integral_minimum >= LOOP_NOZZLE_INTEGRAL_MINIMUM && integral_minimum <= integral_maximum
        && integral_maximum <= LOOP_NOZZLE_INTEGRAL_MAXIMUM && integral_minimum < output_maximum
        && output_maximum >= LOOP_NOZZLE_OUTPUT_LEAST_MAXIMUM
        && output_maximum <= LOOP_NOZZLE_OUTPUT_MAXIMUM;
}
#endif

void settings_keep(void) { kept++; }
void settings_reload(void) { reloaded++; }
void settings_defaults(void) { defaulted++; }

/* ---- the line ---- */

static void send_now(void)
{
    for (int i = 0; i < BYTES_SENT_PER_TICK && (UCSR0B & (1u << UDRIE0)); i++) {
        UDR0 = 0;
        const uint8_t before = UCSR0B;
        USART0_UDRE_vect();
        if (UCSR0B == before) {
            putchar(UDR0);
        }
    }
}

/* The script's next byte comes in. */
static void receive(uint8_t flags)
{
    UCSR0A = (uint8_t)((UCSR0A & (1u << U2X0)) | flags);
    UDR0 = next_byte();
    USART0_RX_vect();
}

static void receive_all(uint16_t count)
{
    while (count-- != 0) {
        receive(0);
    }
}

static void ticks(uint16_t count)
{
    while (count-- != 0) {
        gcode_tick();
        feed_tick();
        heat_bed();
        send_now();
    }
}

/* What the spec has. Not as initial values: a play begins anew with what was 0 only. */
static void begin(void)
{
#if __has_include("loop_spare.h")
    settings.spare_kp = 4.0f;
    settings.spare_ki = 5.0f;
    settings.spare_kd = 6.0f;
#endif
#ifdef LOOP_NOZZLE_OUTPUT_LEAST_MAXIMUM
    settings.nozzle_integral_minimum_percent = LOOP_NOZZLE_INTEGRAL_MINIMUM;
    settings.nozzle_integral_maximum_percent = LOOP_NOZZLE_INTEGRAL_MAXIMUM;
    settings.nozzle_output_maximum_percent = LOOP_NOZZLE_OUTPUT_MAXIMUM;
#endif
}

int main(void)
{
    begin();
    gcode_start();
    for (int command; (command = getchar()) >= 0;) {
        switch (command) {
        case 'r': receive_all(next_word()); break;
        case 't': ticks(next_word()); break;
        case 'c': loop_nozzle.temperature_c = next_float(); break;
        case 'b': BED_C = next_float(); break;
        case 's': settings.nozzle_setpoint_c = (float)next_word(); break;
        case 'w': autotune_nozzle.switches = next_byte(); break;
        case 'a': autotune_nozzle.result = next_byte(); break;
        case 'f': fault_trip(next_byte(), 20.0f); break;
        case 'k': fault_acknowledge(); break;
        case 'l': fault.trips = next_byte(); break;
        case 'x': receive(next_byte()); break;
        default: wrong("a letter that is no command");
        }
    }
    printf("=setpoint %.9g\n=fan %.9g\n=mode %d\n=manual %.9g\n", (double)settings.nozzle_setpoint_c,
        (double)fan_percent, loop_nozzle.mode, (double)loop_nozzle.manual_percent);
    printf("=gains %.9g %.9g %.9g\n", (double)settings.nozzle_kp, (double)settings.nozzle_ki,
        (double)settings.nozzle_kd);
#ifdef LOOP_NOZZLE_OUTPUT_LEAST_MAXIMUM
    printf("=limits %.9g %.9g %.9g\n", (double)settings.nozzle_integral_minimum_percent,
        (double)settings.nozzle_integral_maximum_percent,
        (double)settings.nozzle_output_maximum_percent);
#endif
    printf("=tuning %u\n=feed %d %d %u\n", cycles_asked, feed_is_at, feed_ends_at, disabled);
    unsigned pulled_up = 0;
    for (int port = 0; port < HOST_PORTS; port++) {
        pulled_up += host_port[port];
    }
    printf("=line %u %u %u %u %u\n", UBRR0, UCSR0A & (1u << U2X0), UCSR0B & ~(1u << UDRIE0),
        UCSR0C, pulled_up);
    printf("=silent %u\n", gcode_silent_ticks());
    printf("=fault %d\n=acknowledged %u\n=stored %u %u %u\n=tripped %.9g\n", fault.code,
        acknowledgements, kept, reloaded, defaulted, (double)fault.temperature_c);
    return 0;
}
