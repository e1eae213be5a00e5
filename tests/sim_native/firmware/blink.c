/* A 100 Hz tick on timer 1, idle sleep in between; PB5 toggles, a step is counted every tenth. */
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <stdbool.h>
#include <stdint.h>

struct state {
    uint16_t steps;
    float temperature_c;
    int8_t trend[3];
    struct { uint8_t code; bool latched; } fault;
};
struct state loop_air;
enum mode { COLD, HOT = 300 } mode;
volatile uint8_t ticks;

ISR(TIMER1_COMPA_vect) {
    ticks++;
    PINB = _BV(PB5);
}

int main(void) {
    DDRB = _BV(PB5);
    TCCR1B = _BV(WGM12) | _BV(CS11);        /* CTC, 16 MHz / 8 */
    OCR1A = 19999;
    TIMSK1 = _BV(OCIE1A);
    set_sleep_mode(SLEEP_MODE_IDLE);
    uint8_t seen = 0;
    for (;;) {
        cli();
        sleep_enable();
        sei();
        sleep_cpu();
        sleep_disable();
        if ((uint8_t)(ticks - seen) >= 10) {
            seen += 10;
            loop_air.temperature_c += 0.5f;
            loop_air.trend[2] = -3;
            loop_air.fault.latched = true;
            mode = HOT;
            loop_air.steps++;
        }
    }
}
