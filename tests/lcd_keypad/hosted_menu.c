/* The world around a menu: its keys as codes of the ADC, its display's pins, and a machine that says
 * what it is told and is as a test has put it.
 *
 * The script holds commands: 'p', the number of a place, and its bytes; 't' and 16 bits, ticks; 'f',
 * to show anew, as a control step does; '?' ends what is said so far. What is said are lines: an
 * order; or `>`, the time in ns, RS, and the four bits that a fall of E gives to the display.
 */
#undef _FORTIFY_SOURCE /* it is the firmware that is watched: a world restores all memory */
#include "script.h"

#include "adc.h"
#include "fault.h"
#include "fault_log.h"
#include "guard_chamber.h"
#include "keypad.h"
#include "lcd.h"
#include "loop_chamber.h"
#include "panel.h"
#include "program.h"
#include "progress.h"
#include "sensor_chamber.h"
#include "settings.h"

enum { RS = 1u << 0, ENABLE = 1u << 1, KEYPAD = 1u << 0, TICK_NS = 10000000, MOST_NS = 600000 };

struct fault_state fault;
struct loop_chamber_state loop_chamber;
struct program_state program;
struct settings settings;
static struct stored_program stored[PROGRAM_PLACES];
static struct fault_log_entry entries[FAULT_LOG_SIZE];
static uint8_t is_stored[PROGRAM_PLACES], entries_count, level = 0xFF, fresh, answer, is_saved, is_on;
static uint32_t saves;
static double began_ns, now_ns;

#define AT(place) { &(place), sizeof(place) }

static const struct {
    void *place;
    size_t size;
} PLACES[] = { /* in the order of hosted_menu.PLACES */
    AT(program.state), AT(program.waiting), AT(program.ended), AT(program.segment),
    AT(program.segments), AT(program.clock), AT(program.segment_clock), AT(program.setpoint_c),
    AT(program.energy), AT(loop_chamber.temperature_c), AT(loop_chamber.has_reading), AT(is_on),
    AT(settings.chamber_setpoint_c), AT(settings.chamber_kp), AT(settings.chamber_ki),
    AT(settings.chamber_kd), AT(settings.chamber_maximum_c), AT(settings.chamber_thermocouple),
    AT(fault.code), AT(fault.trips), AT(saves), AT(is_saved), AT(answer), AT(entries_count), AT(entries), AT(stored),
    AT(is_stored), AT(level), AT(fresh),
};

bool adc_is_fresh(void) { return fresh; }
uint8_t adc_upper_bits(void) { return level; }

void world_waits(double us)
{
    static bool was_high;
    const bool high = (PORTB & DDRB & ENABLE) != 0;

    if (was_high && !high) {
        printf(">%.0f %d %d\n", now_ns, (PORTB & DDRB & RS) != 0, (PORTD & DDRD) >> 4);
    }
    was_high = high;
    now_ns += 1000.0 * us;
}

#define TOLD(...) (printf(__VA_ARGS__), answer != 0)
#define TAKES(function, type, order, place) \
    bool function(type value) \
    { \
        const bool done = TOLD(order "\n", value); \
        place = done ? value : place; \
        return done; \
    }

TAKES(loop_chamber_set, float, "setpoint %.9g", settings.chamber_setpoint_c)
TAKES(guard_chamber_set_maximum, float, "maximum %.9g", settings.chamber_maximum_c)
TAKES(sensor_chamber_choose, uint8_t, "type %u", settings.chamber_thermocouple)

void fault_acknowledge(void) { fault.code = TOLD("acknowledge\n") ? FAULT_NONE : fault.code; }
void fault_release(void) { fault.code = TOLD("release\n") ? FAULT_NONE : fault.code; }
bool fault_is_locked(void) { return fault.trips >= LOCKOUT_TRIPS; }
uint32_t progress_saves(void) { return saves; }
bool loop_chamber_is_enabled(void) { return is_on; }
bool loop_chamber_enable(void) { return TOLD("on\n") && (is_on = true); }
void loop_chamber_disable(void) { is_on = TOLD("off\n") ? false : is_on; }
bool program_start(uint8_t number) { return TOLD("start %u\n", number); }
bool program_pause(void) { return TOLD("pause\n"); }
bool program_resume(void) { return TOLD("resume\n"); }
bool program_skip(void) { return TOLD("skip\n"); }
bool program_stop(void) { return TOLD("stop\n"); }
bool program_jump(uint8_t segment) { return TOLD("jump %u\n", segment); }
bool programs_are_saved(void) { return is_saved; }

void settings_keep_chamber(void)
{
    printf("keep %.9g %.9g %.9g\n", settings.chamber_kp, settings.chamber_ki, settings.chamber_kd);
}

const struct fault_log_entry *fault_log_at(uint8_t index)
{
    must(index < FAULT_LOG_SIZE, "an entry behind the end of the list");
    return index < entries_count ? &entries[index] : NULL;
}

bool programs_read(uint8_t number, struct stored_program *into)
{
    memset(into, 0x55, sizeof *into); /* what is copied of an empty place means nothing */
    if (is_stored[number - 1]) {
        *into = stored[number - 1];
    }
    return is_stored[number - 1];
}

bool programs_write(uint8_t number, const struct stored_program *from)
{
    printf("write %u [%s]", number, from->name);
    for (uint8_t i = 0; i < from->segments; i++) {
        const struct program_segment *const each = &from->segment[i];
        printf(" %u/%d/%lu", each->kind, each->to_dc, (unsigned long)each->amount);
    }
    if (TOLD("\n")) {
        stored[number - 1] = *from;
        is_stored[number - 1] = from->segments != 0;
    }
    return answer;
}

static void tick(void)
{
    now_ns = began_ns += TICK_NS;
    panel_tick();
    lcd_tick();
    must(now_ns - began_ns < MOST_NS, "a tick that waits for long");
}

int main(void)
{
    keypad_start();
    lcd_start();
    panel_refresh();
    must(PORTC & KEYPAD, "a keypad's pin that floats without the shield");
    for (int command; (command = getchar()) >= 0;) {
        if (command == 'p') {
            const uint8_t number = next_byte();
            for (size_t i = 0; i < PLACES[number].size; i++) {
                ((uint8_t *)PLACES[number].place)[i] = next_byte();
            }
        } else if (command == 't') {
            for (uint16_t left = next_word(); left-- != 0;) {
                tick();
            }
        } else if (command == 'f') {
            panel_refresh();
        } else {
            puts("?");
        }
    }
    return 0;
}
