/* SPI: one slave that only sends, bit by bit, and a judge of the master's timing.

   It listens to its select and clock pins. While it is selected, each fall of the clock brings the
   next bit; what the bits are is Python's business: see hw_spi_selected. Pins that float are high:
   a board has a pull-up resistor on the select line, or leaves the chip's state to chance. */
#include <stdlib.h>
#include <string.h>
#include "hw.h"

/* An SBI changes its pin at the end of its two cycles, and what a program reads of a pin is up to
   one and a half cycles old (data sheets, "Reading the Pin Value"). */
#define WRITE_TO_READ 4

struct hw_spi {
    hw *h;
    int select, clock, data;
    void *handle;
    hw_spi_timing timing;
    int connected, selected, clock_high;
    uint8_t word[8];
    int driven, position;       /* bits it sends, clocked out so far; then it lets go */
    int shown;                  /* on the data line: HW_NONE, HW_LOW, HW_HIGH */
    uint64_t chosen, released, rose, fell, valid;
    int clocks;                 /* rises since it was selected */
    uint64_t violations[HW_SPI_CHECKS], least[HW_SPI_CHECKS], most[HW_SPI_CHECKS];
};

static void judge(hw_spi *s, int check, uint64_t cycles, uint64_t allowed) {
    if (cycles < s->least[check])
        s->least[check] = cycles;
    if (cycles > s->most[check])
        s->most[check] = cycles;
    if (cycles < allowed)
        s->violations[check]++;
}

static void show(hw_spi *s, int level) {
    if (s->shown == level)
        return;
    if (s->shown)
        pin_hold(s->h, s->data, s->shown == HW_HIGH, 0);
    if (level)
        pin_hold(s->h, s->data, level == HW_HIGH, 1);
    s->shown = level;
}

/* The level of the present bit. */
static int bit(const hw_spi *s) {
    if (s->position >= s->driven)
        return HW_NONE;
    return s->word[s->position / 8] >> (7 - s->position % 8) & 1 ? HW_HIGH : HW_LOW;
}

static void choose(hw_spi *s, uint64_t now) {
    if (s->released)
        judge(s, HW_SPI_IDLE, now - s->released, s->timing.idle);
    s->selected = 1;
    s->chosen = now;
    s->valid = now + s->timing.enable;
    s->position = s->driven = s->clocks = 0;
    hw_spi_selected(s->handle, now);
}

static void release(hw_spi *s, uint64_t now) {
    if (s->clocks)
        judge(s, HW_SPI_HOLD, now - s->fell, s->timing.hold);
    s->selected = 0;
    s->released = now;
    show(s, HW_NONE);
    hw_spi_released(s->handle, now);
}

static void on_select(void *param, int low, uint64_t now) {
    hw_spi *s = param;
    if (!s->connected || low == s->selected)
        return;
    if (low)
        choose(s, now);
    else
        release(s, now);
}

static void rise(hw_spi *s, uint64_t now) {
    if (s->clocks++) {
        judge(s, HW_SPI_LOW, now - s->fell, s->timing.low);
        judge(s, HW_SPI_PERIOD, now - s->rose, s->timing.period);
    } else {
        judge(s, HW_SPI_SETUP, now - s->chosen, s->timing.setup);
    }
    s->rose = now;
}

static void fall(hw_spi *s, uint64_t now) {
    if (s->clocks) {
        judge(s, HW_SPI_HIGH, now - s->rose, s->timing.high);
        show(s, bit(s));        /* by now it is there, whether anybody looked or not */
    }
    s->fell = now;
    s->position++;
    s->valid = now + s->timing.output;
}

static void on_clock(void *param, int low, uint64_t now) {
    hw_spi *s = param;
    if (!s->connected || !s->selected)
        return;
    if (low)
        fall(s, now);
    else
        rise(s, now);
}

/* Who reads too early reads what was there before. */
static void on_sampled(void *param, uint64_t now) {
    hw_spi *s = param;
    if (!s->connected || !s->selected)
        return;
    uint64_t since = s->position ? s->fell : s->chosen, seen = now - WRITE_TO_READ;
    judge(s, HW_SPI_READ, seen > since ? seen - since : 0, s->valid - since);
    if (seen >= s->valid)
        show(s, bit(s));
}

static void unheard(void *param, int low, uint64_t now) { (void)param, (void)low, (void)now; }
static void unseen(void *param, uint64_t now) { (void)param, (void)now; }

static int listen(hw_spi *s) {
    struct wire_listener select = {on_select, unseen, s};
    struct wire_listener clock = {on_clock, unseen, s};
    struct wire_listener data = {unheard, on_sampled, s};
    return pin_listen(s->h, s->select, select) || pin_listen(s->h, s->clock, clock)
        || pin_listen(s->h, s->data, data);
}

hw_spi *hw_spi_new(hw *h, int select, int clock, int data, void *handle,
                   const hw_spi_timing *timing) {
    hw_spi *s = h->spi_count < HW_SPIS ? calloc(1, sizeof *s) : NULL;
    if (!s)
        return NULL;
    s->h = h;
    s->select = select;
    s->clock = clock;
    s->data = data;
    s->handle = handle;
    s->timing = *timing;
    s->connected = 1;
    memset(s->least, 0xff, sizeof s->least);
    h->spis[h->spi_count++] = s;
    return listen(s) ? NULL : s;
}

void spi_free(hw *h) {
    for (int i = 0; i < h->spi_count; i++)
        free(h->spis[i]);
}

void hw_spi_retime(hw_spi *s, const hw_spi_timing *timing) { s->timing = *timing; }

void hw_spi_connect(hw_spi *s, int connected) {
    if (s->selected && !connected)
        release(s, s->h->avr->cycle);
    s->connected = connected;
    on_select(s, s->h->pins[s->select].line_low, s->h->avr->cycle);
}

void hw_spi_load(hw_spi *s, const uint8_t *word, int bits) {
    memcpy(s->word, word, sizeof s->word);
    s->driven = bits;
}

uint64_t hw_spi_violations(hw_spi *s, int check) { return s->violations[check]; }

uint64_t hw_spi_seen(hw_spi *s, int check, int end) {
    return end == HW_SPI_LEAST ? s->least[check] : s->most[check];
}
