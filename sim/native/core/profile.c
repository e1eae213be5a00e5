/* Profile: cycles by function, and the longest stretches of code.

   It is called for each instruction (profile_before, profile_after), or by our core only at changes
   (profiled.c), with the same results. */
#include <stdlib.h>
#include <string.h>
#include "fast.h"
#include "profile.h"

int hw_profile_start(hw *h, const uint16_t *function_of_word, const uint32_t *starts,
                     int functions) {
    size_t words = (h->avr->flashend + 1) / 2;
    struct profile *p = calloc(1, sizeof *p);
    if (!p || h->profile)
        return free(p), -1;
    p->function_of_word = malloc(words * sizeof *function_of_word);
    p->starts = malloc((size_t)functions * sizeof *starts);
    p->ends = calloc((size_t)functions, sizeof *p->ends);
    p->totals = calloc((size_t)functions, sizeof *p->totals);
    p->traced = calloc((size_t)functions, 1);
    p->coverage = calloc(words, 1);
    memcpy(p->function_of_word, function_of_word, words * sizeof *function_of_word);
    memcpy(p->starts, starts, (size_t)functions * sizeof *starts);
    for (uint32_t word = 0; word < words; word++)
        if (function_of_word[word] != NO_FUNCTION)
            p->ends[function_of_word[word]] = 2 * word + 2;
    p->words = words;
    p->lowest = hw_stack_pointer(h);
    h->profile = p;
    profile_reset(h);
    fast_forget(h);
    return 0;
}

void profile_free(hw *h) {
    struct profile *p = h->profile;
    if (!p)
        return;
    free(p->function_of_word);
    free(p->starts);
    free(p->ends);
    free(p->totals);
    free(p->traced);
    free(p->coverage);
    free(p);
    h->profile = NULL;
    fast_forget(h);
}

void hw_profile_stop(hw *h) { profile_free(h); }

/* Code may jump beyond the end of the flash. */
static uint16_t function_at(const struct profile *p, uint32_t pc) {
    return pc / 2 < p->words ? p->function_of_word[pc / 2] : NO_FUNCTION;
}

static void open_window(struct profile *p, uint32_t pc, uint64_t now) {
    p->window = (struct window){.low = pc, .high = pc, .began = now};
}

void profile_reset(hw *h) {
    struct profile *p = h->profile;
    p->depth = 0;
    p->masked = 0;
    p->ever_enabled = 0;
    open_window(p, h->avr->pc, h->avr->cycle);
}

static void close_window(struct profile *p, uint64_t now) {
    uint64_t stayed = now - p->window.began - p->window.paused;
    if (stayed > p->longest_busy.cycles)
        p->longest_busy = (hw_stretch){.cycles = stayed, .at = p->window.began,
                                       .pc = p->window.low};
}

static void follow_window(struct profile *p, uint32_t pc, uint64_t now) {
    uint32_t low = pc < p->window.low ? pc : p->window.low;
    uint32_t high = pc > p->window.high ? pc : p->window.high;
    if (high - low >= WINDOW) {
        close_window(p, now);
        open_window(p, pc, now);
        return;
    }
    p->window.low = low;
    p->window.high = high;
}

static void end_mask(struct profile *p, uint64_t now) {
    uint64_t lasted = now - p->masked_since;
    uint16_t function = function_at(p, p->masked_pc);
    if (function != NO_FUNCTION && lasted > p->totals[function].masked)
        p->totals[function].masked = lasted;
    if (lasted > p->longest_masked.cycles)
        p->longest_masked = (hw_stretch){.cycles = lasted, .at = p->masked_since,
                                         .pc = p->masked_pc};
}

static void follow_mask(hw *h, uint32_t pc) {
    struct profile *p = h->profile;
    if (h->avr->sreg[S_I]) {
        if (p->masked && p->ever_enabled)
            end_mask(p, h->avr->cycle);
        p->masked = 0;
        p->ever_enabled = 1;
    } else if (!p->masked) {
        p->masked = 1;
        p->masked_since = p->began;
        p->masked_pc = pc;
    }
}

static void trace_entry(hw *h, uint16_t function) {
    struct profile *p = h->profile;
    if (function == NO_FUNCTION)
        return;
    p->totals[function].calls++;
    if (!p->traced[function])
        return;
    hw_entry *e = log_add(h, HW_ENTRY_LOG);
    e->cycle = h->avr->cycle;
    e->pc = p->starts[function];
}

static void push(hw *h, uint32_t pc, uint16_t sp, uint64_t began, int kind) {
    struct profile *p = h->profile;
    uint16_t function = function_at(p, pc);
    trace_entry(h, function);
    if (p->depth == DEPTH)
        return;
    p->frames[p->depth++] = (struct frame){.sp = sp, .function = function, .began = began,
                                           .kind = kind, .window = p->window};
}

/* Subtract the time of an interrupt from all functions that it interrupted. */
static void forget(struct profile *p, const struct frame *f, uint64_t now) {
    uint64_t lasted = now - f->began;
    if (f->kind != INTERRUPT)
        return;
    for (int i = 0; i < p->depth; i++)
        p->frames[i].stolen += lasted - f->stolen;
    p->window = f->window;
    p->window.paused += lasted;
}

static void pop(hw *h) {
    struct profile *p = h->profile;
    uint64_t now = h->avr->cycle;
    struct frame f = p->frames[--p->depth];
    uint64_t lasted = now - f.began - f.stolen;
    if (f.function != NO_FUNCTION) {
        hw_function *t = &p->totals[f.function];
        t->total += lasted;
        if (lasted > t->longest)
            t->longest = lasted;
    }
    forget(p, &f, now);
}

/* A return ends all functions that were entered at this stack depth or deeper. */
static void returned(hw *h) {
    struct profile *p = h->profile;
    uint16_t sp = hw_stack_pointer(h);
    while (p->depth && p->frames[p->depth - 1].sp <= sp)
        pop(h);
}

/* A jump to another function ends a function that was itself jumped to; a called one continues. */
static void jumped(hw *h, uint32_t pc, uint16_t sp) {
    struct profile *p = h->profile;
    struct frame *top = p->depth ? &p->frames[p->depth - 1] : NULL;
    if (top && top->kind == JUMPED && top->sp == sp)
        pop(h);
    push(h, pc, sp, h->avr->cycle, JUMPED);
}

void profile_before(hw *h) {
    struct profile *p = h->profile;
    p->pc = h->avr->pc;
    p->sp = hw_stack_pointer(h);
    p->began = h->avr->cycle;
    if (p->pc / 2 < p->words)
        p->coverage[p->pc / 2] = 1;
    follow_window(p, p->pc, p->began);
}

static int is_call(uint16_t op) {
    if (op == 0xd000)           /* rcall .+0 only makes room on the stack */
        return 0;
    return (op & 0xf000) == 0xd000 || (op & 0xfe0e) == 0x940e || op == 0x9509 || op == 0x9519;
}

/* A jump to the start of another function is a call that returns to the caller's caller. Interrupt
   vectors are such jumps, too, but their handlers are already recorded as entered. */
static int is_tail_call(struct profile *p, uint16_t from, uint32_t pc) {
    uint16_t to = function_at(p, pc);
    return from != to && to != NO_FUNCTION && p->starts[to] == pc &&
           from != function_at(p, 0);
}

static int is_return(uint16_t op) { return op == 0x9508 || op == 0x9518; }

/* Between OUT SPH and OUT SPL the stack pointer is half old and half new: ignore it. */
static void note_stack(struct profile *p, uint16_t op, uint16_t sp) {
    uint16_t written = op & 0xfe0f;
    if (written == 0xbe0e)
        p->half_moved = 1;
    else if (written == 0xbe0d)
        p->half_moved = 0;
    profile_stack(p, sp);
}

void profile_after(hw *h, uint32_t pc) {
    struct profile *p = h->profile;
    avr_t *avr = h->avr;
    if (p->pc / 2 >= p->words)
        return;
    uint16_t function = function_at(p, p->pc);
    uint16_t op = (uint16_t)(avr->flash[p->pc] | avr->flash[p->pc + 1] << 8);
    uint16_t sp = hw_stack_pointer(h);
    if (function != NO_FUNCTION)
        p->totals[function].own += avr->cycle - p->began;
    note_stack(p, op, sp);
    if (is_call(op))
        push(h, pc, p->sp, avr->cycle, CALLED);
    else if (is_return(op))
        returned(h);
    else if (is_tail_call(p, function, pc))
        jumped(h, pc, (uint16_t)(sp + avr->address_size));
    follow_mask(h, p->pc);
}

/* Whether the I flag and the stack pointer are recorded; not so at the beginning of a profile. */
int profile_settled(hw *h) {
    struct profile *p = h->profile;
    return (p->ever_enabled || !h->avr->sreg[S_I]) &&
           (p->half_moved || hw_stack_pointer(h) >= p->lowest);
}

void profile_enter(hw *h, uint32_t pc) {
    struct profile *p = h->profile;
    p->function = function_at(p, pc);
    p->counted = h->avr->cycle;
    p->size = 0;                /* the window is not updated yet */
}

void profile_count(hw *h) {
    struct profile *p = h->profile;
    if (p->function != NO_FUNCTION)
        p->totals[p->function].own += h->avr->cycle - p->counted;
    p->counted = h->avr->cycle;
}

/* A jump or the end of its range has left the code; calls and returns are reported separately. */
void profile_leave(hw *h, uint32_t pc) {
    struct profile *p = h->profile;
    profile_count(h);
    if (is_tail_call(p, p->function, pc))
        jumped(h, pc, (uint16_t)(hw_stack_pointer(h) + h->avr->address_size));
}

/* Code outside all functions is watched word by word. */
static void watch(struct profile *p, uint32_t pc) {
    int known = p->function != NO_FUNCTION;
    uint32_t from = known ? p->starts[p->function] : pc;
    uint32_t end = known ? p->ends[p->function] : pc + 2;
    uint32_t low = p->window.low, high = low + WINDOW;
    p->from = from > low ? from : low;
    p->size = (end < high ? end : high) - p->from;
}

/* Go to code outside the watched range: of another function, or in another window. */
void profile_cross(hw *h, uint32_t pc) {
    struct profile *p = h->profile;
    if (function_at(p, pc) != p->function) {
        profile_leave(h, pc);
        profile_enter(h, pc);
    }
    follow_window(p, pc, h->avr->cycle);
    watch(p, pc);
}

void profile_called(hw *h, uint32_t pc) {
    uint16_t sp = hw_stack_pointer(h);
    profile_stack(h->profile, sp);
    profile_count(h);
    push(h, pc, (uint16_t)(sp + h->avr->address_size), h->avr->cycle, CALLED);
    profile_enter(h, pc);
}

void profile_returned(hw *h, uint32_t pc) {
    profile_count(h);
    returned(h);
    profile_enter(h, pc);
}

/* Follow the I flag. pc: of the instruction; if it turns interrupts off, it begins now. */
void profile_mask(hw *h, uint32_t pc) {
    h->profile->began = h->avr->cycle;
    follow_mask(h, pc);
}

/* The function of a vector: most vectors are jumps to it. */
static uint32_t handler(hw *h) {
    uint32_t pc = h->avr->pc;
    const uint8_t *f = h->avr->flash + pc;
    uint16_t op = (uint16_t)(f[0] | f[1] << 8);
    if (op == 0x940c)
        return 2u * (uint32_t)(f[2] | f[3] << 8);
    if ((op & 0xf000) == 0xc000)
        return (uint32_t)((int32_t)pc + 2 + 2 * ((int16_t)(op << 4) >> 4));
    return pc;
}

/* Called when the vector is reached: its entry cycles are already counted. */
void profile_interrupt(hw *h) {
    struct profile *p = h->profile;
    uint16_t sp = hw_stack_pointer(h);
    uint32_t pc = handler(h);
    uint64_t began = h->avr->cycle - (uint64_t)h->entry_cycles;
    if (sp < p->lowest)
        p->lowest = sp;
    p->began = began;
    follow_mask(h, pc);
    push(h, pc, (uint16_t)(sp + h->avr->address_size), began, INTERRUPT);
    open_window(p, h->avr->pc, h->avr->cycle);
}

void profile_slept(hw *h, uint64_t cycles) {
    struct profile *p = h->profile;
    p->window.paused += cycles;
    for (int i = 0; i < p->depth; i++)
        p->frames[i].stolen += cycles;
}

void profile_sleep(hw *h) {
    close_window(h->profile, h->avr->cycle);
    open_window(h->profile, h->avr->pc, h->avr->cycle);
}

void hw_profile_trace_entry(hw *h, int function, int on) {
    h->profile->traced[function] = (uint8_t)on;
}

const hw_function *hw_profile_functions(hw *h) { return h->profile->totals; }
const uint8_t *hw_profile_coverage(hw *h) { return h->profile->coverage; }
hw_stretch hw_profile_masked(hw *h) { return h->profile->longest_masked; }
hw_stretch hw_profile_busy(hw *h) { return h->profile->longest_busy; }
uint16_t hw_profile_stack(hw *h) { return h->profile->lowest; }
