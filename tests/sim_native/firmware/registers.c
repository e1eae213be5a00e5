/* A plain reader and writer of a chip with registers on four wires, timed by busy waits. CS is PB2,
   SCK PB0, SO PB4, SI PB3. A request is put in RAM: the bytes to send, which become those that
   came, how many, the clock's level at rest and the edge that takes a bit (SPI modes), whether SI is
   too late, how many bits are left out at the end, how long CS is low before the first, and whether
   SO has no pull-up. It tells whether SO was high before. */
#include <avr/io.h>
#include <stdint.h>
#include <util/delay.h>

struct {
    uint8_t bytes[20];
    uint8_t count, mode, late, bits_short, hold_ms, floats;
    volatile uint8_t go;
    uint8_t idle_high;
    uint16_t done;
} request;

#define PUT(pin, high) ((high) ? (PORTB |= _BV(pin)) : (PORTB &= (uint8_t)~_BV(pin)))
static void clock(uint8_t high) { PUT(PB0, high); }
static void tell(uint8_t bit) { PUT(PB3, bit); }

/* Modes 1 and 3: a bit changes with the edge away from rest, and is taken with the one back. In 0
   and 2 it is taken just before the edge away. */
static uint8_t exchange(uint8_t out, uint8_t bits) {
    uint8_t rest = request.mode >> 1 & 1, in = 0;
    while (bits--) {
        if (!(request.mode & 1))
            tell(out >> 7);
        _delay_us(1);
        uint8_t bit = PINB >> PB4 & 1;
        clock(!rest);
        if (request.mode & 1 && !request.late)
            tell(out >> 7);
        _delay_us(1);
        in = (uint8_t)(in << 1 | (request.mode & 1 ? PINB >> PB4 & 1 : bit));
        clock(rest);
        if (request.late)
            tell(out >> 7);
        out = (uint8_t)(out << 1);
    }
    return in;
}

int main(void) {
    PORTB = _BV(PB2);
    DDRB = _BV(PB2) | _BV(PB0) | _BV(PB3);
    for (;;) {
        while (!request.go) {}
        request.go = 0;
        PUT(PB4, !request.floats);
        clock(request.mode >> 1 & 1);
        _delay_us(1);
        request.idle_high = PINB >> PB4 & 1;
        PORTB &= (uint8_t)~_BV(PB2);
        for (uint8_t i = 0; i < request.hold_ms; i++)
            _delay_ms(1);
        for (uint8_t i = 0; i < request.count; i++)
            request.bytes[i] = exchange(request.bytes[i],
                                        i + 1 == request.count ? 8 - request.bits_short : 8);
        _delay_us(1);
        PORTB |= _BV(PB2);
        request.done++;
    }
}
