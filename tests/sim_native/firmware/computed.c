/* Floats, wide integers, a switch by table, strings in flash, and interrupts all the while. */
#include <stdlib.h>
#include <math.h>
#include <string.h>
volatile uint8_t ticks;
volatile struct { float real[24]; int32_t whole[16]; uint64_t wide[4]; char text[16]; } found;
static const char WORDS[][6] PROGMEM = {"alpha", "beta", "gamma", "delta"};
ISR(TIMER1_COMPA_vect) { ticks++; }
/* The last byte of RAM is to tell the end: no stack there. */
__attribute__((naked, used, section(".init3"))) void early(void) { SP = RAMEND - 8; }
__attribute__((noinline)) static int32_t chosen(uint8_t n, int32_t x) {
    switch (n & 7) {
        case 0: return x / 7; case 1: return x % 1000; case 2: return x * 3; case 3: return ~x;
        case 4: return x >> 3; case 5: return -x; case 6: return labs(x); default: return x ^ n;
    }
}
__attribute__((noinline)) void stop(void) { for (;;) {} }
int main(void) {
    float a = 1.25f, b = -0.5f;
    uint64_t wide = 0x123456789abcdefULL;
    TCCR1B = _BV(WGM12) | _BV(CS10); OCR1A = 999; TIMSK1 = _BV(OCIE1A);
    sei();
    for (uint8_t i = 0; i < 96; i++) {
        a = a * 0.97f + b * 0.25f + i; b = a / 3.0f - sqrtf(fabsf(b)) * 7.0f;
        found.real[i % 24] += a; found.real[(i + 7) % 24] -= b;
        found.whole[i & 15] += chosen(i, lroundf(a * 100.0f) + (int32_t)b);
        wide = wide * 6364136223846793005ULL + i; found.wide[i & 3] ^= wide >> (i & 31);
        strncpy_P((char *)found.text + (i & 7), WORDS[i & 3], 6);
    }
    while (ticks < 40) {}
    cli();
    TIMSK1 = 0; ticks = 40;
    *(volatile uint8_t *)RAMEND = 0xA5;
    stop();
}
