/* A plain DS18B20 master on PC1, timed by busy waits: what the chip's tests talk with.
   A request is put in RAM: bytes to send after a reset, then how many to read. */
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <stdint.h>
#include <util/delay.h>

struct {
    uint8_t send, receive, data[16];
    volatile uint8_t go;
    uint8_t answered, idle_high;
    uint16_t done;
} request;

static void low(void) { DDRC |= _BV(PC1); }
static void release(void) { DDRC &= (uint8_t)~_BV(PC1); }
static uint8_t level(void) { return (PINC >> PC1) & 1; }

static uint8_t slot(uint8_t one) {
    uint8_t seen;
    low();
    if (one) {
        _delay_us(ONE_LOW_US);
        release();
        _delay_us(READ_AT_US - ONE_LOW_US - 0.5);
        seen = level();
        _delay_us(SLOT_US - READ_AT_US);
    } else {
        _delay_us(ZERO_LOW_US);
        release();
        seen = 0;
        _delay_us(SLOT_US - ZERO_LOW_US);
    }
    return seen;
}

static uint8_t byte(uint8_t out) {
    uint8_t in = 0;
    for (uint8_t i = 0; i < 8; i++) {
        in = (uint8_t)(in >> 1 | (slot(out & 1) ? 0x80 : 0));
        out >>= 1;
    }
    return in;
}

static uint8_t reset(void) {
    low();
    _delay_us(RESET_LOW_US);
    release();
    _delay_us(RESET_SAMPLE_US);
    uint8_t answered = !level();
    _delay_us(RESET_HIGH_US - RESET_SAMPLE_US);
    return answered;
}

/* Search for the one chip on the line: each bit, its complement, then follow it. */
static void search(void) {
    for (uint8_t i = 0; i < 64; i++) {
        uint8_t bit = slot(1), inverse = slot(1);
        uint8_t *into = &request.data[i / 8];
        *into = (uint8_t)(*into >> 1 | (bit ? 0x80 : 0));
        if (bit == inverse) {
            request.answered = 2;
            return;
        }
        slot(bit);
    }
}

int main(void) {
    for (;;) {
        while (!request.go) {}
        request.go = 0;
        request.answered = reset();
        for (uint8_t i = 0; i < request.send; i++)
            byte(request.data[i]);
        if (request.receive == 0xff)
            search();
        else
            for (uint8_t i = 0; i < request.receive; i++)
                request.data[i] = byte(0xff);
        request.idle_high = level();
        request.done++;
    }
}
