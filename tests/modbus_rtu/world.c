/* The world around the generated Modbus files, on this computer: a line and two loops, air (with
 * gains) and bed.
 *
 * Standard input holds commands of one letter:
 *   'f' count (16 bits) bytes: these come in, then silence, then the main loop runs to the end of
 *       the answer;  'r' count bytes: these come in;  'x' flags byte: one with these flags;
 *   'q': silence;  'm': the main loop, and the answer to its end;  'M': the main loop alone;
 *   'p' count (8 bits): so many bytes leave;  't' count (16 bits): ticks;
 *   'v' what (8 bits), value (float): a value of the world;  's': show the state;
 *   'l': how the line is set up.
 * 'f' and 'm' write the bytes that were sent, with their count (16 bits) before them; 's' a text and
 * 'l' registers in the same form.
 */
#include "script.h"

#include "autotune_air.h"
#include "config.h"
#include "current_hot_bed.h"
#include "fault.h"
#include "loop_air.h"
#include "loop_bed.h"
#include "modbus.h"
#include "modbus_line.h"
#include "pins.h"
#include "response_bed.h"
#include "settings.h"

void USART0_RX_vect(void);
void USART0_TX_vect(void);
void TIMER2_COMPA_vect(void);

#ifndef MODBUS_SILENCE_MATCHES
#define MODBUS_SILENCE_MATCHES 1u
#endif
#define DRIVER 1u /* PC0 */
#define LISTENING (1u << TXEN0 | 1u << TXCIE0 | 1u << RXEN0 | 1u << RXCIE0)
#define SPEAKING (1u << TXEN0 | 1u << TXCIE0)

struct fault_state fault;
struct settings settings;
struct autotune_air_state autotune_air;
struct current_hot_bed_state current_hot_bed;
struct response_bed_state response_bed;

static uint8_t cycles_asked;
static unsigned kept, defaulted;
static uint32_t now_s;

/* What is alike for both loops; bed stays automatic. */
#define LOOP(name, NAME)                                                                       \
    static struct {                                                                            \
        bool enabled, released;                                                                \
        uint8_t mode, state;                                                                   \
        float percent;                                                                         \
    } name;                                                                                    \
    struct loop_##name##_state loop_##name;                                                    \
    uint8_t loop_##name##_state(void) { return name.state; }                                   \
    bool loop_##name##_may_set(float setpoint_c)                                               \
    {                                                                                          \
        return !(name.mode == MODE_TUNING && setpoint_c != settings.name##_setpoint_c)         \
            && setpoint_c >= LOOP_##NAME##_SETPOINT_MINIMUM_C                                  \
            && setpoint_c <= LOOP_##NAME##_SETPOINT_MAXIMUM_C;                                 \
    }                                                                                          \
    bool loop_##name##_set(float setpoint_c)                                                   \
    {                                                                                          \
        const bool may = loop_##name##_may_set(setpoint_c);                                    \
        settings.name##_setpoint_c = may ? setpoint_c : settings.name##_setpoint_c;            \
        return may;                                                                            \
    }                                                                                          \
    bool loop_##name##_may_enable(void)                                                        \
    {                                                                                          \
        return fault.code == FAULT_NONE && (name.released || name.enabled);                    \
    }                                                                                          \
    bool loop_##name##_enable(void)                                                            \
    {                                                                                          \
        const bool may = loop_##name##_may_enable();                                           \
        name.enabled |= may;                                                                   \
        return may;                                                                            \
    }                                                                                          \
    void loop_##name##_disable(void)                                                           \
    {                                                                                          \
        name.enabled = false;                                                                  \
        name.released = true;                                                                  \
        name.mode = MODE_AUTOMATIC;                                                            \
    }                                                                                          \
    bool loop_##name##_is_enabled(void) { return name.enabled; }

LOOP(air, AIR)
LOOP(bed, BED)

uint32_t clock_seconds(void);
uint32_t clock_seconds(void) { return now_s; }

bool fault_is_locked(void) { return fault.trips >= LOCKOUT_TRIPS; }

void fault_acknowledge(void)
{
    if (fault.code != FAULT_NONE) {
        fault.code = FAULT_NONE;
        fault.acknowledgements++;
        air.enabled = bed.enabled = false;
        air.mode = MODE_AUTOMATIC;
    }
}

void settings_keep(void) { kept++; }

void settings_defaults(void)
{
    defaulted++;
    settings.air_kp = LOOP_AIR_KP;
    settings.air_ki = LOOP_AIR_KI;
    settings.air_kd = LOOP_AIR_KD;
}

bool loop_air_set_manual_percent(float value)
{
    must(value >= 0.0f && value <= 100.0f, "a duty that was not looked at");
    air.percent = value;
    return true;
}

bool loop_air_set_manual(float value)
{
    must(fault.code == FAULT_NONE && air.enabled, "manual that was not looked at");
    loop_air_set_manual_percent(value);
    air.mode = MODE_MANUAL;
    return true;
}

void loop_air_set_automatic(void)
{
    if (air.mode == MODE_MANUAL) {
        air.mode = MODE_AUTOMATIC;
    }
}

float loop_air_manual_percent(void) { return air.percent; }

uint8_t loop_air_mode(void) { return air.mode; }

bool loop_air_tune(float target_c, uint8_t cycles)
{
    must(fault.code == FAULT_NONE && air.enabled && loop_air_set(target_c),
        "a tuning that was not looked at");
    air.mode = MODE_TUNING;
    cycles_asked = (uint8_t)(cycles_asked + cycles);
    return true;
}

void loop_air_stop_tuning(void)
{
    if (air.mode == MODE_TUNING) {
        air.enabled = air.released = false;
        air.mode = MODE_AUTOMATIC;
    }
}

static void put(const void *data, unsigned count)
{
    putchar((int)(count & 0xFF));
    putchar((int)(count >> 8));
    fwrite(data, 1, count, stdout);
    fflush(stdout); /* somebody may wait for it */
}

/* The script's next byte comes in. */
static void receive(uint8_t flags)
{
    const uint8_t byte = next_byte();

    if ((UCSR0B & (1u << RXEN0)) == 0) {
        return;
    }
    TCNT2++; /* it runs all the time */
    TIFR2 = 0;
    TIMSK2 |= 1u << OCIE2B; /* somebody else's */
    UCSR0A = flags;
    UDR0 = byte;
    USART0_RX_vect();
    must(TIMSK2 & (1u << OCIE2A) && (uint8_t)(OCR2A - TCNT2) == MODBUS_SILENCE_COUNTS,
        "the silence is not measured from this byte on");
    must(TIFR2 == 1u << OCF2A, "a match of the silence before is still there");
}

static void receive_all(unsigned count)
{
    while (count-- != 0) {
        receive(0);
    }
}

static void silence(void)
{
    unsigned matches = 0;

    for (; (TIMSK2 & (1u << OCIE2A)) != 0; matches++) {
        must(matches != MODBUS_SILENCE_MATCHES, "the silence does not end");
        TCNT2 = OCR2A;
        TIMER2_COMPA_vect();
        must((TIMSK2 & (1u << OCIE2A)) == 0 || (uint8_t)(OCR2A - TCNT2) == MODBUS_SILENCE_COUNTS,
            "the silence goes on with another length");
    }
    must(matches == 0 || matches == MODBUS_SILENCE_MATCHES, "the silence is too short");
    must((TIMSK2 & ~(1u << OCIE2B)) == 0, "interrupts of the timer that nobody asked for");
}

static uint8_t line[2 * MODBUS_FRAME_SIZE];
static unsigned sent;

static void leave(unsigned count)
{
    while (count-- != 0 && UCSR0B == SPEAKING) {
        must(PORTC & DRIVER, "the driver is off before the last byte has left");
        must(sent < sizeof line, "an answer without end");
        line[sent++] = UDR0;
        USART0_TX_vect();
    }
    must(UCSR0B == SPEAKING || UCSR0B == LISTENING, "it neither listens nor speaks");
    must(UCSR0B == SPEAKING || (PORTC & DRIVER) == 0, "the driver stays on");
}

static void run_main(void)
{
    if (modbus_line_is_asked()) {
        USART0_TX_vect(); /* one that nobody waits for */
        must(modbus_line_is_asked(), "an interrupt takes a request back that is not answered yet");
        modbus_answer();
        must(!modbus_line_is_asked(), "it asks to be answered again");
    }
}

static void run_to_end(void)
{
    run_main();
    leave(sizeof line);
    put(line, sent);
    sent = 0;
}

static void set(uint8_t what)
{
    const float value = next_float();

    switch (what) {
    case 'f': fault.code = (uint8_t)value; break;
    case 'l': fault.trips = (uint8_t)value; break;
    case 'F': fault.temperature_c = value; break;
    case 'T': fault.time_s = (uint32_t)value; break;
    case 'n': now_s = (uint32_t)value; break;
    case 't': loop_air.temperature_c = value; break;
    case 'b': loop_bed.temperature_c = value; break;
    case 'H': loop_bed.has_reading = (uint8_t)value; break;
    case 'N': loop_bed.missing = (uint8_t)value; break;
    case 'h': loop_air.has_reading = (uint8_t)value; break;
    case 'm': loop_air.missing = (uint8_t)value; break;
    case 'r': loop_air.reading_status = (uint8_t)value; break;
    case 'd': loop_air.duty_percent = value; break;
    case 'c': loop_air.setpoint_c = value; break;
    case 'S': air.state = (uint8_t)value; break;
    case 'B': bed.state = (uint8_t)value; break;
    case 'a': autotune_air.result = (uint8_t)value; break;
    case 'A': current_hot_bed.amperes = value; break;
    case 'e': response_bed.measured = (uint8_t)value; break;
    case 's': response_bed.settling_s = value; break;
    case 'o': response_bed.overshoot_k = value; break;
    default: wrong("what is that?");
    }
}

static void show(void)
{
    char text[400];
    const int size = snprintf(text, sizeof text,
        "%d %d %.9g %d %d %d %.9g %.9g %.9g %.9g %.9g %d %d %u %u %d %u %u %u %u %u %u %u %d",
        fault.code, fault.acknowledgements, (double)settings.air_setpoint_c, air.enabled,
        air.released, air.mode, (double)air.percent, (double)settings.air_kp, (double)settings.air_ki,
        (double)settings.air_kd, (double)settings.bed_setpoint_c, bed.enabled, bed.released, kept,
        defaulted, cycles_asked, modbus_counters.messages, modbus_counters.errors,
        modbus_counters.exceptions, modbus_counters.requests, modbus_counters.unanswered,
        modbus_counters.overruns, modbus_silent_ticks(), modbus_was_heard());

    put(text, (unsigned)size);
}

static void do_one(int command)
{
    switch (command) {
    case 'f': receive_all(next_word()); silence(); run_to_end(); break;
    case 'r': receive_all(next_word()); break;
    case 'q': silence(); break;
    case 'm': run_to_end(); break;
    case 'M': run_main(); break;
    case 'p': leave(next_byte()); break;
    case 's': show(); break;
    case 'x': receive(next_byte()); break;
    case 't':
        for (unsigned left = next_word(); left != 0; left--) {
            modbus_tick();
        }
        break;
    case 'v': set(next_byte()); break;
    case 'l': put((const uint8_t[]) { UBRR0 & 0xFF, (uint8_t)(UBRR0 >> 8), UCSR0A, UCSR0C, TCCR2A,
        TCCR2B, PORTE & 1u, DDRE & 1u }, 8); break;
    default: wrong("what is that?");
    }
}

int main(void)
{
    air.enabled = bed.enabled = false;
    settings.air_setpoint_c = LOOP_AIR_SETPOINT_INITIAL_C;
    settings.bed_setpoint_c = LOOP_BED_SETPOINT_INITIAL_C;
    settings_defaults();
    defaulted = 0;
    TCCR2A = PORTC = 0xFF; /* whatever they were */
    modbus_start();
    must(UCSR0B == LISTENING && (PORTC & DRIVER) == 0 && DDRC & DRIVER, "it does not listen");
    for (int command; (command = getchar()) >= 0;) {
        do_one(command);
    }
    return 0;
}
