/* A plain reader of a converter on three wires, timed by busy waits: what the chips' tests talk with.
   CS is PB2, SCK PB0, SO PB4. A request is put in RAM: how many bits, and how long to hold CS. */
#include <avr/io.h>
#include <stdint.h>
#include <util/delay.h>

struct {
    uint32_t word;
    uint8_t bits, hold_ms, pull_up;
    volatile uint8_t go;
    uint8_t idle_high;
    uint16_t done;
} request;

static uint8_t level(void) { return (PINB >> PB4) & 1; }

static void answer(void) {
    uint32_t word = 0;
    PORTB &= (uint8_t)~_BV(PB2);
    _delay_us(1);
    for (uint8_t i = 0; i < request.bits; i++) {
        word = word << 1 | level();
        PORTB |= _BV(PB0);
        _delay_us(1);
        PORTB &= (uint8_t)~_BV(PB0);
        _delay_us(2);
    }
    for (uint8_t i = 0; i < request.hold_ms; i++)
        _delay_ms(1);
    PORTB |= _BV(PB2);
    request.word = word;
}

int main(void) {
    PORTB = _BV(PB2);
    DDRB = _BV(PB2) | _BV(PB0);
    for (;;) {
        while (!request.go) {}
        request.go = 0;
        if (request.pull_up)
            PORTB |= _BV(PB4);
        else
            PORTB &= (uint8_t)~_BV(PB4);
        request.idle_high = level();
        answer();
        request.done++;
    }
}
