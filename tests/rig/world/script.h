/* What every world has: the chip's ports and timers as memory, and its script on standard input. */
#ifndef RIG_SCRIPT_H
#define RIG_SCRIPT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define REGISTER /* here they are */
#include <avr/io.h>

volatile uint8_t host_port[HOST_PORTS];
volatile uint8_t host_ddr[HOST_PORTS];
volatile struct host_timer host_timer[HOST_TIMERS];

/* A pin that nobody drives follows its pull-up. */
uint8_t host_level(uint8_t port)
{
    return host_port[port];
}

/* The firmware does what it must not: the play ends, and what it said is kept. */
_Noreturn static inline void wrong(const char *what)
{
    fflush(stdout);
    fprintf(stderr, "%s\n", what);
    fflush(stderr);
    _exit(3);
}

/* Of the script: 8 bits, or 16, the low ones first; 0 behind its end. */
static inline uint8_t next_byte(void)
{
    const int byte = getchar();

    return byte < 0 ? 0 : (uint8_t)byte;
}

static inline uint16_t next_word(void)
{
    const uint8_t low = next_byte();

    return (uint16_t)(low | next_byte() << 8);
}

static inline float next_float(void)
{
    float value = 0.0f;

    return fread(&value, sizeof value, 1, stdin) == 1 ? value : 0.0f;
}

#endif
