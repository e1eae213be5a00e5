/* The world around a kiln's firmware: the display's line, a thermometer, an EEPROM.
 *
 * The script holds commands, each a letter and a number of 32 bits: 'r', a count, and bytes to
 * receive; 'd' and 'b', the same with a damaged byte, or one after a lost one, before them; 'o', a count and an order that is done at
 * once, and whether it was taken is the next state's; 't', ticks; 'c', a temperature in degrees;
 * 'f', a fault's code; 'l', how many trips count; 'n', whether the sensor answers; 'p', to forget the
 * gains that are not kept; 'w', what the clock shows in seconds; 'm', what a program's clocks show,
 * and its energy; 's', the count of control steps; 'a', whether the display answers when it is asked
 * for its page.
 * Each '?' writes `=`, the state as a line of words; each instruction that is sent is written as `>`,
 * the tick, the divisor of the line, itself, a new line.
 */
#undef _FORTIFY_SOURCE /* it is the firmware that is watched: a world restores all memory */
#include "script.h"

#include <avr/eeprom.h>

#include "config.h"
#include "fault.h"
#include "fault_log.h"
#include "gate.h"
#include "guard_chamber.h"
#include "loop_chamber.h"
#include "nextion.h"
#include "nextion_frame.h"
#include "nextion_orders.h"
#include "nextion_pages.h"
#include "nextion_points.h"
#include "program.h"
#include "progress.h"
#include "response_chamber.h"
#include "sensor_chamber.h"
#include "settings.h"

void USART0_RX_vect(void);
void USART0_UDRE_vect(void);

enum {
    BYTES_PER_TICK_AND_DIVISOR = 2000, /* 16 MHz, double speed, ten bits a byte, 100 ticks a second */
    EEPROM_BYTES = 4096,
    LISTENS = 1u << TXEN0 | 1u << RXEN0 | 1u << RXCIE0
};

uint8_t reset_cause;
volatile uint16_t reset_hang_mark;
#ifdef LOCKOUT_WAIT_S
uint16_t reset_power_mark;
#endif

static uint32_t now_ticks;
static uint8_t eeprom[EEPROM_BYTES];
static int32_t raw_now = (int32_t)(20.0f / SENSOR_CHAMBER_STEP_C);
static bool answers = true;
static bool display_answers = true;
static char instruction[256];
static unsigned instruction_size;
static bool taken;
static uint16_t divisor;
static uint32_t sent_last_ticks;

uint32_t clock_seconds(void);
uint32_t clock_seconds(void) { return now_ticks / 100u; }

/* ---- EEPROM ---- */

bool eeprom_is_ready(void) { return true; }

static uint8_t *cell(const uint8_t *place)
{
    must((uintptr_t)place < EEPROM_BYTES, "an access outside the EEPROM");
    return &eeprom[(uintptr_t)place];
}

uint8_t eeprom_read_byte(const uint8_t *place) { return *cell(place); }

void eeprom_read_block(void *to, const void *from, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        ((uint8_t *)to)[i] = *cell((const uint8_t *)from + i);
    }
}

void eeprom_write_byte(uint8_t *place, uint8_t value) { *cell(place) = value; }

/* ---- the sensor ---- */

void sensor_chamber_begin(void) { }

uint8_t sensor_chamber_take(int32_t *raw)
{
    if (!answers) {
        return FAULT_SENSOR_NO_ANSWER;
    }
    memcpy(raw, &raw_now, sizeof *raw);
    return READING_OK;
}

bool sensor_chamber_choose(uint8_t type)
{
    return !loop_chamber_is_enabled() && program.state == PROGRAM_IDLE
        && settings_set_chamber_thermocouple(type);
}

/* ---- the line ---- */

static void sent(uint8_t byte)
{
    static unsigned ends = 3;

    if (ends == 3) {
        printf(">%lu %u ", (unsigned long)now_ticks, UBRR0);
        ends = 0;
        instruction_size = 0;
    }
    if (byte != 0xFF) {
        putchar(byte);
        instruction[instruction_size++ % sizeof instruction] = (char)byte;
    } else if (++ends == 3) {
        putchar('\n');
    }
}

static void receive(uint8_t byte, uint8_t flags)
{
    must(UCSR0B & (1u << RXEN0) && UCSR0B & (1u << RXCIE0), "a line that is not listened to");
    UCSR0A |= flags;
    UDR0 = byte;
    USART0_RX_vect();
    UCSR0A &= (uint8_t)~flags;
}

/* The page that it was told last, if it was asked. */
static void answer(void)
{
    if (display_answers && instruction_size == 6 && memcmp(instruction, "sendme", 6) == 0) {
        const uint8_t bytes[] = { 0x66, pages_shown, 0xFF, 0xFF, 0xFF };
        for (unsigned i = 0; i < sizeof bytes; i++) {
            receive(bytes[i], 0);
        }
    }
    instruction_size = 0;
}

/* ---- the firmware's life ---- */

static void tick(void)
{
    now_ticks++;
    gate_tick();
    gate_renew_main();
    nextion_tick();
    loop_chamber_tick();
    fault_log_tick();
    settings_tick();
    progress_tick();
    programs_tick();
    must(UBRR0 == divisor || now_ticks - sent_last_ticks > 1, "a divisor of bytes that still go out");
    divisor = UBRR0;
    for (int i = BYTES_PER_TICK_AND_DIVISOR / (divisor + 1); i > 0 && (UCSR0B & (1u << UDRIE0)); i--) {
        USART0_UDRE_vect();
        sent(UDR0);
        sent_last_ticks = now_ticks;
    }
    must((UCSR0B & (uint8_t) ~(1u << UDRIE0)) == LISTENS, "a line that is set otherwise");
    if (!(UCSR0B & (1u << UDRIE0))) {
        answer();
    }
}

static void start(void)
{
    memset(eeprom, 0xFF, sizeof eeprom);
    settings_start();
    progress_start();
    guard_chamber_reset();
    program_start_up();
    nextion_start();
    divisor = UBRR0;
    loop_chamber_start();
}

/* All that an order may change, and the most of what a page shows. */
static void show_state(void)
{
    printf("=fault=%u acks=%u setpoint=%.9g kp=%.9g ki=%.9g kd=%.9g maximum=%.9g type=%u ", fault.code,
        fault.acknowledgements, (double)settings.chamber_setpoint_c, (double)settings.chamber_kp,
        (double)settings.chamber_ki, (double)settings.chamber_kd, (double)settings.chamber_maximum_c,
        settings.chamber_thermocouple);
    printf("settled=%.9g over=%.9g ", (double)response_chamber.settling_s,
        (double)response_chamber.overshoot_k);
    printf("form=%u divisor=%u speed=%u ", UCSR0C, UBRR0, UCSR0A);
    printf("taken=%d on=%d mode=%d percent=%.9g ", taken, loop_chamber_is_enabled(),
        loop_chamber_mode(), (double)loop_chamber_manual_percent());
    printf("waiting=%u works=%u saves=%lu temperature=%.9g target=%.9g duty=%.9g ", program.waiting,
        loop_chamber.enabled, (unsigned long)progress_saves(), (double)loop_chamber.temperature_c,
        (double)loop_chamber.setpoint_c, (double)loop_chamber.duty_percent);
    printf("clock=%lu passed=%lu energy=%lu ", (unsigned long)program.clock,
        (unsigned long)program.segment_clock, (unsigned long)program.energy);
    printf("page=%u state=%u number=%u segment=%u ended=%u shown=%u marked=%u name=%s points=",
        pages_shown, program.state, program.number, program.segment, program.ended, points_number,
        points_marked, points_shown.name);
    for (unsigned i = 0; i < points_shown.segments && i < PROGRAM_POINTS; i++) {
        const struct program_segment *const segment = &points_shown.segment[i];
        printf("%u/%d/%lu,", segment->kind, segment->to_dc, (unsigned long)segment->amount);
    }
    putchar('\n');
}

static void receive_many(uint32_t count)
{
    while (count-- != 0) {
        receive(next_byte(), 0);
    }
}

static void order_now(uint32_t size)
{
    (void)frame_take('#');
    while (size-- != 0) {
        (void)frame_take(next_byte());
    }
    taken = frame_take(';') == FRAME_ORDER && orders_do();
}

/* The sum that the program's checksum has; its argument, which each step clears, can keep it. */
static uint8_t sum_of_program(void)
{
    uint8_t sum = 0;

    for (uint8_t i = 0; i < sizeof program; i++) {
        sum = (uint8_t)(sum + ((const uint8_t *)&program)[i]);
    }
    return sum;
}

static void follow(int command, uint32_t number)
{
    switch (command) {
    case 'd': receive('#', 1u << FE0); receive_many(number); break;
    case 'b': receive('#', 1u << DOR0); receive_many(number); break;
    case 'r': receive_many(number); break;
    case 'o': order_now(number); break;
    case 't':
        for (uint32_t left = number; left-- != 0;) {
            tick();
        }
        break;
    case 'c': raw_now = (int32_t)((float)(int32_t)number / SENSOR_CHAMBER_STEP_C); break;
    case 'f': fault_trip((uint8_t)number, 20.0f); break;
    case 'l': fault.trips = (uint8_t)number; break;
    case 'n': answers = number != 0; break;
    case 'p': settings_reload(); break;
    case 'w': now_ticks = 100u * number; break;
    case 'm':
        program.argument = sum_of_program();
        program.clock = program.segment_clock = number;
        program.energy = 4500u * number;
        program.argument = (uint8_t)(2u * program.argument - sum_of_program());
        break;
    case 'a': display_answers = number != 0; break;
    case 's': loop_chamber.steps = (uint16_t)number; break;
    default: show_state();
    }
}

int main(void)
{
    start();
    for (int command; (command = getchar()) >= 0;) {
        const uint32_t low = next_word();
        follow(command, low | (uint32_t)next_word() << 16);
    }
    return 0;
}
