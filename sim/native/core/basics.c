/* Logs, timers, limits, and Python's access to the processor. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "hw.h"

void *log_add(hw *h, int log) {
    struct log *l = &h->logs[log];
    if (l->size + l->record > l->capacity) {
        l->capacity = l->capacity ? 2 * l->capacity : 64 * l->record;
        l->data = realloc(l->data, l->capacity);
        if (!l->data)
            abort();
    }
    uint8_t *entry = l->data + l->size;
    l->size += l->record;
    if (l->size > HW_LOG_FULL)
        h->log_full = 1;
    for (size_t i = 0; i < l->record; i++)
        entry[i] = 0;
    return entry;
}

const void *hw_log_data(hw *h, int log) { return h->logs[log].data; }

size_t hw_log_count(hw *h, int log) {
    return h->logs[log].record ? h->logs[log].size / h->logs[log].record : 0;
}

void hw_log_clear(hw *h, int log) {
    h->logs[log].size = 0;
    h->log_full = 0;
    for (int i = 0; i < HW_LOGS; i++)
        if (h->logs[i].size > HW_LOG_FULL)
            h->log_full = 1;
}

static avr_cycle_count_t on_due(struct avr_t *avr, avr_cycle_count_t when, void *param) {
    struct timer *t = param;
    (void)avr, (void)when;
    t->armed = 0;
    t->fire(t->h, t->param, t->due);
    return 0;
}

struct timer *timer_new(hw *h, timer_fn fire, void *param) {
    if (h->timer_count == HW_TIMERS)
        return NULL;
    struct timer *t = &h->timers[h->timer_count++];
    t->h = h;
    t->fire = fire;
    t->param = param;
    return t;
}

void timer_set(struct timer *t, uint64_t due) {
    uint64_t now = t->h->avr->cycle;
    t->due = due;
    t->armed = 1;
    avr_cycle_timer_register(t->h->avr, due > now ? due - now : 0, on_due, t);
}

void timer_stop(struct timer *t) {
    t->armed = 0;
    avr_cycle_timer_cancel(t->h->avr, on_due, t);
}

void limit(hw *h, const char *format, ...) {
    va_list args;
    if (h->limit)
        return;
    h->limit = 1;
    va_start(args, format);
    vsnprintf(h->message, sizeof h->message, format, args);
    va_end(args);
}

/* End the run before simavr would write to memory outside the processor. */
void crash(hw *h, const char *why) {
    snprintf(h->message, sizeof h->message, "%s", why);
    h->avr->state = cpu_Crashed;
}

/* Returns a chip at the pins, freed with the processor; NULL if there are `most` of its kind. */
void *chip_new(hw *h, int *count, int most, size_t size) {
    void *chip = *count < most ? calloc(1, size) : NULL;
    if (chip)
        h->chips[h->chip_count++] = chip, ++*count;
    return chip;
}

/* The times of a bus's master. */
void checks_start(hw_check *checks, int count) {
    for (int i = 0; i < count; i++)
        checks[i] = (hw_check){.least = UINT64_MAX};
}

void check_add(hw_check *check, uint64_t cycles, int wrong) {
    check->least = cycles < check->least ? cycles : check->least;
    check->most = cycles > check->most ? cycles : check->most;
    check->violations += wrong != 0;
}

avr_io_t *io_find(hw *h, const char *kind, int nth) {
    for (avr_io_t *io = h->avr->io_port; io; io = io->next)
        if (io->kind && !strcmp(io->kind, kind) && nth-- == 0)
            return io;
    return NULL;
}

/* Continue at another address; a sleeping processor wakes up. */
void hw_jump(hw *h, uint32_t pc) {
    h->avr->pc = pc;
    if (h->avr->state == cpu_Sleeping)
        h->avr->state = cpu_Running;
}

/* Write a byte as an instruction would: registers take effect, and their pins follow. */
void hw_poke(hw *h, uint16_t address, uint8_t value) {
    avr_t *avr = h->avr;
    avr_io_addr_t a = AVR_DATA_TO_IO(address);
    if (address < 32 || a >= sizeof avr->io / sizeof avr->io[0]) {
        avr->data[address] = value;
        return;
    }
    write_register(avr, address, value);
}

void hw_reference_core(hw *h, int on) { h->reference = on; }

uint8_t hw_flags(hw *h) {
    uint8_t flags = 0;
    for (int i = 0; i < 8; i++)
        flags |= (uint8_t)(h->avr->sreg[i] << i);
    return flags;
}

const char *hw_message(hw *h) { return h->message; }
uint32_t hw_flash_size(hw *h) { return h->avr->flashend + 1; }
uint32_t hw_ram_end(hw *h) { return h->avr->ramend; }
uint8_t *hw_ram(hw *h) { return h->avr->data; }
uint8_t *hw_flash(hw *h) { return h->avr->flash; }
uint64_t hw_cycle(hw *h) { return h->avr->cycle; }
uint64_t hw_sleep_cycles(hw *h) { return h->sleep_cycles; }
uint32_t hw_program_counter(hw *h) { return h->avr->pc; }
int hw_asleep_for_good(hw *h) { return h->dead_sleep; }

uint16_t hw_stack_pointer(hw *h) {
    return (uint16_t)(h->avr->data[R_SPL] | h->avr->data[R_SPH] << 8);
}

void hw_sleep_register(hw *h, uint16_t address, uint8_t enable, uint8_t mode) {
    h->sleep_register = address;
    h->sleep_enable = enable;
    h->sleep_mode = mode;
}
