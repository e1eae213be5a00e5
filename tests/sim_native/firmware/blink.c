/* A 100 Hz tick on timer 1, idle sleep in between; PB5 toggles, and a float is added to. */
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <stdint.h>

volatile float temperature_c;
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
    for (;;) {
        cli();
        sleep_enable();
        sei();
        sleep_cpu();
        sleep_disable();
        temperature_c += 0.5f * ticks;
    }
}
