/* The profile, as far as the core notes things in it itself; see profiled.c. */
#pragma once

#include "hw.h"

#define WINDOW 16               /* bytes of flash: 8 words */
#define DEPTH 128
#define NO_FUNCTION 0xffff

struct window {
    uint32_t low, high;
    uint64_t began, paused;     /* cycle of the first instruction; cycles of interrupts within */
};

struct frame {
    uint16_t sp;                /* before the call pushed */
    uint16_t function;
    enum { CALLED, JUMPED, INTERRUPT } kind;
    uint64_t began, stolen;     /* stolen: cycles of interrupts within */
    struct window window;       /* of the interrupted code */
};

struct profile {
    uint16_t *function_of_word;
    size_t words;
    uint32_t *starts, *ends;    /* each function is in one piece */
    int depth, masked, ever_enabled;
    hw_function *totals;
    uint8_t *traced, *coverage;
    struct frame frames[DEPTH];
    struct window window;
    uint32_t pc, masked_pc;
    uint16_t sp, lowest;
    int half_moved;             /* the stack pointer: SPH is written, SPL not yet */
    uint64_t began, masked_since;
    hw_stretch longest_masked, longest_busy;

    /* Within a burst of our core: the function that runs, the cycle up to which its own are counted,
       and the code around it, in bytes, in which neither function nor window changes. */
    uint16_t function;
    uint64_t counted;
    uint32_t from, size;
};

static inline void profile_stack(struct profile *p, uint16_t sp) {
    if (sp < p->lowest && !p->half_moved)
        p->lowest = sp;
}

/* How far straight code has gone is seen where a jump leaves it: an interrupt returns to it. */
static inline void profile_jump(struct profile *p, uint32_t from) {
    if (from > p->window.high)
        p->window.high = from;
}

/* Of our core, h->avr->cycle being that of now; pc: of the next instruction. */
void profile_enter(hw *h, uint32_t pc);
void profile_count(hw *h);
void profile_leave(hw *h, uint32_t pc);
void profile_cross(hw *h, uint32_t pc);
void profile_called(hw *h, uint32_t pc);
void profile_returned(hw *h, uint32_t pc);
void profile_mask(hw *h, uint32_t pc);

void profile_free(hw *h);
int profile_settled(hw *h);
void profile_before(hw *h);
void profile_after(hw *h, uint32_t pc);   /* pc: of the next instruction */
void profile_interrupt(hw *h);
void profile_sleep(hw *h);
void profile_slept(hw *h, uint64_t cycles);
void profile_reset(hw *h);
