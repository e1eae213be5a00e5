/* SPI: one slave, with or without registers, bit by bit, with a check of the master's timing.

   It watches its select and clock pins. A slave without registers sends the next bit at each fall of
   the clock. One with registers takes the clock's level at select as its idle level, sends a bit at
   each edge away from it, and samples one at each edge back (modes 1 and 3): first it receives the
   address, then it sends its answer while it receives more. Python interprets the bits: see
   hw_spi_selected and hw_spi_addressed. Floating pins are high: a board needs a pull-up resistor on
   the select line, otherwise the chip's state is random. */
#include <string.h>
#include "peripherals/pins.h"
#include "callbacks.h"

/* An SBI changes its pin at the end of its two cycles, and a program reads a pin's level that is up
   to one and a half cycles old (data sheets, "Reading the Pin Value"). */
#define WRITE_TO_READ 4
#define ADDRESS_BITS 8
#define TOLD_BYTES 17           /* an address and sixteen registers; more are ignored */

struct hw_spi {
    hw *h;
    hw_spi_pins pins;
    void *handle;
    hw_spi_timing timing;
    int connected, selected, rests_high;
    uint8_t word[16];
    int driven, position;       /* bits to send, and bits sent so far; after them the line floats */
    int shown;                  /* its level on the data line: HW_NONE, HW_LOW, HW_HIGH */
    uint8_t told[TOLD_BYTES];
    int heard;                  /* bits received since it was selected */
    uint64_t chosen, released, went, back, valid;
    uint64_t changed, taken;    /* last change of its input; last sample of it */
    int clocks;                 /* edges away from idle since it was selected */
    hw_check checks[HW_SPI_CHECKS];
};

static int has_registers(const hw_spi *s) { return s->pins.input >= 0; }

static void judge(hw_spi *s, int check, uint64_t cycles, uint64_t allowed) {
    check_add(&s->checks[check], cycles, cycles < allowed);
}

/* Check how long the clock was at a level. */
static void judge_level(hw_spi *s, int high, uint64_t cycles) {
    judge(s, high ? HW_SPI_HIGH : HW_SPI_LOW, cycles, high ? s->timing.high : s->timing.low);
}

static void show(hw_spi *s, int level) {
    if (s->shown == level)
        return;
    if (s->shown)
        pin_hold(s->h, s->pins.data, s->shown == HW_HIGH, 0);
    if (level)
        pin_hold(s->h, s->pins.data, level == HW_HIGH, 1);
    s->shown = level;
}

/* The level of the present bit. An answer's first bit is sent at the first edge after the address. */
static int bit(const hw_spi *s) {
    int at = has_registers(s) ? s->position - 1 - ADDRESS_BITS : s->position;
    if (at < 0 || at >= s->driven)
        return HW_NONE;
    return s->word[at / 8] >> (7 - at % 8) & 1 ? HW_HIGH : HW_LOW;
}

static void choose(hw_spi *s, uint64_t now) {
    if (s->released)
        judge(s, HW_SPI_IDLE, now - s->released, s->timing.idle);
    s->selected = 1;
    s->rests_high = has_registers(s) && !s->h->pins[s->pins.clock].line_low;
    s->chosen = now;
    s->valid = now + s->timing.enable;
    s->position = s->driven = s->clocks = s->heard = 0;
    hw_spi_selected(s->handle, now);
}

static void release(hw_spi *s, uint64_t now) {
    if (s->clocks)
        judge(s, HW_SPI_HOLD, now - s->back, s->timing.hold);
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

/* Send the next bit, after its delay. */
static void shift(hw_spi *s, uint64_t now) {
    s->position++;
    s->valid = now + s->timing.output;
}

static void hear(hw_spi *s, uint64_t now) {
    judge(s, HW_SPI_TOLD, now - s->changed, s->timing.told);
    s->taken = now;
    if (s->heard == 8 * TOLD_BYTES)
        return;
    uint8_t *byte = &s->told[s->heard / 8];
    *byte = (uint8_t)(*byte << 1 | !s->h->pins[s->pins.input].line_low);
    if (++s->heard == ADDRESS_BITS)
        hw_spi_addressed(s->handle, s->told[0], now);
}

static void go(hw_spi *s, uint64_t now) {
    if (s->clocks++) {
        judge_level(s, s->rests_high, now - s->back);
        judge(s, HW_SPI_PERIOD, now - s->went, s->timing.period);
    } else {
        judge(s, HW_SPI_SETUP, now - s->chosen, s->timing.setup);
    }
    s->went = now;
    if (has_registers(s))
        shift(s, now);
}

static void come_back(hw_spi *s, uint64_t now) {
    if (s->clocks) {
        judge_level(s, !s->rests_high, now - s->went);
        show(s, bit(s));        /* the delay is over by now */
    }
    s->back = now;
    if (has_registers(s))
        hear(s, now);
    else
        shift(s, now);
}

static void on_clock(void *param, int low, uint64_t now) {
    hw_spi *s = param;
    if (!s->connected || !s->selected)
        return;
    if (low == s->rests_high)
        go(s, now);
    else
        come_back(s, now);
}

/* A read that is too early gets the level of the bit before. */
static void on_sampled(void *param, uint64_t now) {
    hw_spi *s = param;
    if (!s->connected || !s->selected)
        return;
    uint64_t edge = has_registers(s) ? s->went : s->back;
    uint64_t since = s->position ? edge : s->chosen, seen = now - WRITE_TO_READ;
    judge(s, HW_SPI_READ, seen > since ? seen - since : 0, s->valid - since);
    if (seen >= s->valid)
        show(s, bit(s));
}

static void on_input(void *param, int low, uint64_t now) {
    hw_spi *s = param;
    (void)low;
    if (s->connected && s->selected && s->heard)
        judge(s, HW_SPI_KEPT, now - s->taken, s->timing.kept);
    s->changed = now;
}

static void unheard(void *param, int low, uint64_t now) { (void)param, (void)low, (void)now; }
static void unseen(void *param, uint64_t now) { (void)param, (void)now; }

static int listen(hw_spi *s) {
    struct wire_listener select = {on_select, unseen, s};
    struct wire_listener clock = {on_clock, unseen, s};
    struct wire_listener data = {unheard, on_sampled, s};
    struct wire_listener input = {on_input, unseen, s};
    return pin_listen(s->h, s->pins.select, select) || pin_listen(s->h, s->pins.clock, clock)
        || pin_listen(s->h, s->pins.data, data)
        || (has_registers(s) && pin_listen(s->h, s->pins.input, input));
}

hw_spi *hw_spi_new(hw *h, hw_spi_pins pins, void *handle, const hw_spi_timing *timing) {
    hw_spi *s = chip_new(h, &h->spi_count, HW_SPIS, sizeof *s);
    if (!s)
        return NULL;
    s->h = h;
    s->pins = pins;
    s->handle = handle;
    s->timing = *timing;
    s->connected = 1;
    checks_start(s->checks, HW_SPI_CHECKS);
    return listen(s) ? NULL : s;
}

void hw_spi_retime(hw_spi *s, const hw_spi_timing *timing) { s->timing = *timing; }

void hw_spi_connect(hw_spi *s, int connected) {
    if (s->selected && !connected)
        release(s, s->h->avr->cycle);
    s->connected = connected;
    on_select(s, s->h->pins[s->pins.select].line_low, s->h->avr->cycle);
}

void hw_spi_load(hw_spi *s, const uint8_t *word, int bits) {
    memcpy(s->word, word, sizeof s->word);
    s->driven = bits;
}

int hw_spi_told(hw_spi *s, uint8_t *into) {
    memcpy(into, s->told, sizeof s->told);
    return s->heard / 8;
}

const hw_check *hw_spi_checks(hw_spi *s) { return s->checks; }
