/* What every world has: the chip's ports and timers as memory, and its script on standard input. */
#ifndef RIG_SCRIPT_H
#define RIG_SCRIPT_H

#include <setjmp.h>
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

#ifdef IN_PROCESS

/* A library plays in the process that has loaded it, and as often as it is asked. The world is
 * linked first: from here to the end is all memory of world and firmware, and each play begins with
 * it as it was at first. */
static char first = 1; /* not 0, for then it would not be in .data */
extern char _end[] __attribute__((visibility("hidden")));
static char *image;
static jmp_buf end_of_play;

int main(void);
int world_play(const char *script, size_t size, char **said, size_t *length);
int world_play(const char *script, size_t size, char **said, size_t *length)
{
    const size_t all = (size_t)(_end - &first);

    if (image == NULL) {
        image = malloc(all);
        memcpy(image, &first, all);
    }
    memcpy(&first, image, all);
    stdin = fmemopen((void *)(uintptr_t)script, size, "r");
    stdout = open_memstream(said, length);
    int status = setjmp(end_of_play);
    if (status == 0) {
        status = main();
    }
    fclose(stdin);
    fclose(stdout);
    return status;
}

/* The firmware does what it must not: the play ends, and what it said is this. */
_Noreturn static inline void wrong(const char *what)
{
    fprintf(stdout, "\n%s", what);
    longjmp(end_of_play, 3);
}

#else

_Noreturn static inline void wrong(const char *what)
{
    fflush(stdout);
    fprintf(stderr, "%s\n", what);
    _exit(3); /* no complaint about what is still open */
}

#endif

static inline void must(bool holds, const char *otherwise)
{
    if (!holds) {
        wrong(otherwise);
    }
}

/* The script's next 8 bits, or 16, the low ones first; 0 behind its end. */
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
