/* The world around the generated G-code files, on this computer: a serial line, one tool, one fan.
 *
 * Standard input holds commands of one letter: 'r', a count (16 bits) and bytes to receive;
 * 't', a count (16 bits) of ticks; 'c', a temperature in degrees (16 bits, signed); 'f', a fault's
 * code, and 'a', a tuning's result (8 bits each). What is sent goes to standard output; `=` lines show the state at the end.
 */
#include <math.h>

#include "script.h"

#include "autotune_nozzle.h"
#include "config.h"
#include "fault.h"
#include "gcode.h"
#include "loop_nozzle.h"
#include "output_part_fan.h"
#include "settings.h"

void USART0_RX_vect(void);
void USART0_UDRE_vect(void);

/* Of 115200 baud, in a tick. */
enum { BYTES_SENT_PER_TICK = 115 };

struct fault_state fault;
struct settings settings;
struct loop_nozzle_state loop_nozzle;
struct autotune_nozzle_state autotune_nozzle;
static float fan_percent;
static unsigned acknowledgements, kept, reloaded, defaulted;

void fault_trip(uint8_t code, float temperature_c)
{
    if (fault.code == FAULT_NONE) {
        fault.code = code;
        fault.temperature_c = temperature_c;
    }
}

void fault_acknowledge(void)
{
    if (fault.code != FAULT_NONE) {
        fault.code = FAULT_NONE;
        acknowledgements++;
        settings.nozzle_setpoint_c = 0.0f;
    }
}

bool loop_nozzle_set(float setpoint_c)
{
    if (setpoint_c != 0.0f
        && (fault.code != FAULT_NONE || !(setpoint_c >= LOOP_NOZZLE_SETPOINT_MINIMUM_C)
            || setpoint_c > LOOP_NOZZLE_SETPOINT_MAXIMUM_C)) {
        return false;
    }
    settings.nozzle_setpoint_c = setpoint_c;
    return true;
}

bool loop_nozzle_set_manual(float percent)
{
    if (fault.code != FAULT_NONE || !(percent >= 0.0f) || percent > 100.0f) {
        return false;
    }
    loop_nozzle.manual_percent = percent;
    loop_nozzle.mode = 1;
    return true;
}

bool loop_nozzle_is_ready(void)
{
    return fault.code == FAULT_NONE && settings.nozzle_setpoint_c != 0.0f
        && fabsf(settings.nozzle_setpoint_c - loop_nozzle.temperature_c) <= 1.0f;
}

/* The experiment itself is not here: the world says how it ends. */
bool loop_nozzle_tune(float target_c, uint8_t cycles)
{
    if (target_c == 0.0f || cycles < 1 || !loop_nozzle_set(target_c)) {
        return false;
    }
    autotune_nozzle.result = 1;
    return true;
}

void loop_nozzle_stop_tuning(void)
{
    autotune_nozzle.result = 4;
    settings.nozzle_setpoint_c = 0.0f;
}

void output_part_fan_set(float percent)
{
    fan_percent = percent;
}

void settings_keep(void)
{
    kept++;
}

void settings_reload(void)
{
    reloaded++;
}

void settings_defaults(void)
{
    defaulted++;
}

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

static void receive(uint16_t count)
{
    for (int byte; count-- != 0 && (byte = getchar()) >= 0;) {
        UDR0 = (uint8_t)byte;
        USART0_RX_vect();
    }
}

static void ticks(uint16_t count)
{
    while (count-- != 0) {
        gcode_tick();
        send_now();
    }
}

int main(void)
{
    gcode_start();
    for (int command; (command = getchar()) >= 0;) {
        switch (command) {
        case 'r':
            receive(next_word());
            break;
        case 't':
            ticks(next_word());
            break;
        case 'c':
            loop_nozzle.temperature_c = (float)(int16_t)next_word();
            break;
        case 'a':
            autotune_nozzle.result = next_byte();
            break;
        case 'f':
            fault_trip(next_byte(), 20.0f);
            break;
        default:
            wrong("a letter that is no command");
        }
    }
    printf("=setpoint %.9g\n=fan %.9g\n=mode %d\n=manual %.9g\n", (double)settings.nozzle_setpoint_c,
        (double)fan_percent, loop_nozzle.mode, (double)loop_nozzle.manual_percent);
    printf("=gains %.9g %.9g %.9g\n", (double)settings.nozzle_kp, (double)settings.nozzle_ki,
        (double)settings.nozzle_kd);
    printf("=fault %d\n=acknowledged %u\n=stored %u %u %u\n", fault.code, acknowledgements, kept,
        reloaded, defaulted);
    return 0;
}
