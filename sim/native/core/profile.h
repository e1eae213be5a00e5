/* The part of the profile that the core itself updates; see profiled.c. */
#pragma once

#include "hw.h"

#define WINDOW 16               /* bytes of flash: 8 words */
#define DEPTH 128
#define NO_FUNCTION 0xffff

struct window {
    uint32_t low, high;
    uint64_t began, paused;     /* first cycle; cycles of interrupts and sleep within */
};

struct frame {
    uint16_t sp;                /* before the call pushed */
    uint16_t function;
    enum { CALLED, JUMPED, INTERRUPT } kind;
    uint64_t began, stolen;     /* stolen: cycles of interrupts and sleep within */
    struct window window;       /* the interrupted code's */
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

    /* During a burst of our core: the running function, the cycle up to which its own cycles are
       counted, and the code range, in bytes, in which neither function nor window changes. */
    uint16_t function;
    uint64_t counted;
    uint32_t from, size;
};

static inline void profile_stack(struct profile *p, uint16_t sp) {
    if (sp < p->lowest && !p->half_moved)
        p->lowest = sp;
}

/* Record the end of straight code, at the jump that leaves it: an interrupt returns there. */
static inline void profile_jump(struct profile *p, uint32_t from) {
    if (from > p->window.high)
        p->window.high = from;
}

/* For our core, with h->avr->cycle up to date; pc: of the next instruction. */
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
