/* 1-Wire: one slave on a line, bit by bit, with a check of the master's timing.

   The slave sees the line as others drive it. A low of 480 us or more is a reset; every other fall
   begins a slot, in which the slave either receives (it samples the line once) or sends (it holds
   the line low for a 0). Python interprets the bits: see hw_onewire_received. */
#include <string.h>
#include "peripherals/pins.h"
#include "callbacks.h"

enum mode { IGNORE, RECEIVE, SEND, BUSY, SEARCH };

struct hw_onewire {
    hw *h;
    int pin;
    void *handle;
    hw_onewire_timing timing;
    int connected, holding;
    enum mode mode;
    uint8_t data[16];
    int bits, position;
    int first;                  /* nothing received since the reset */
    uint64_t busy_until;
    uint64_t fell, rose, line_rose, reset_ended;
    int slot_open, sending, seen_sample;
    struct timer *presence, *release;
    uint64_t resets;
    hw_check checks[HW_OW_CHECKS];
};

static void seen(hw_onewire *w, int check, uint64_t cycles, int wrong) {
    check_add(&w->checks[check], cycles, wrong);
}

static void hold(hw_onewire *w, int low) {
    if (w->holding == low)
        return;
    w->holding = low;
    pin_hold(w->h, w->pin, 0, low);
    if (!low)
        w->line_rose = w->h->avr->cycle;
}

static void on_presence(hw *h, void *param, uint64_t when) {
    hw_onewire *w = param;
    (void)h;
    hold(w, 1);
    timer_set(w->release, when + w->timing.presence_low);
}

static void on_release(hw *h, void *param, uint64_t when) {
    (void)h, (void)when;
    hold(param, 0);
}

static int bit_to_send(hw_onewire *w) {
    int bit = w->data[w->position / 8] >> (w->position % 8) & 1;
    switch (w->mode) {
        case SEND: return bit;
        case BUSY: return w->h->avr->cycle >= w->busy_until;
        case SEARCH: return w->bits == 0 ? bit : !bit;  /* the bit, then its complement */
        default: return 1;
    }
}

static int sends(const hw_onewire *w) {
    return w->mode == SEND || w->mode == BUSY || (w->mode == SEARCH && w->bits < 2);
}

static void deliver(hw_onewire *w) {
    uint8_t data[sizeof w->data];
    int first = w->first, bits = w->position;
    memcpy(data, w->data, sizeof data);
    w->mode = IGNORE;
    w->first = 0;
    hw_onewire_received(w->handle, first, data, bits, w->h->avr->cycle);
}

/* One bit of a search: sent, sent inverted, then the master's choice is received. */
static void searched(hw_onewire *w, int choice) {
    int bit = w->data[w->position / 8] >> (w->position % 8) & 1;
    if (w->bits < 2) {
        w->bits++;
        return;
    }
    w->bits = 0;
    if (choice != bit)
        w->mode = IGNORE;
    else if (++w->position == 64)
        deliver(w);
}

static void received(hw_onewire *w, int bit) {
    w->data[w->position / 8] |= (uint8_t)(bit << w->position % 8);
    if (++w->position == w->bits)
        deliver(w);
}

static void sent(hw_onewire *w) {
    if (w->mode == SEND && ++w->position == w->bits)
        w->mode = IGNORE;       /* the line then reads as ones */
}

/* Check a low: a 1 and a read slot are short, a 0 is long; the slave's sample distinguishes them. */
static void judge_low(hw_onewire *w, uint64_t low) {
    const hw_onewire_timing *t = &w->timing;
    if (w->sending || low < t->sample)
        seen(w, HW_OW_ONE_LOW, low, low < t->low_least || low > t->one_most);
    else
        seen(w, HW_OW_ZERO_LOW, low, low < t->zero_least || low > t->zero_most);
}

static void end_slot(hw_onewire *w, uint64_t low) {
    judge_low(w, low);
    int bit = low < w->timing.sample;
    if (w->mode == SEARCH)
        searched(w, bit);
    else if (w->sending)
        sent(w);
    else if (w->mode == RECEIVE)
        received(w, bit);
}

/* Check the time before a slot: since the slot before began and ended, or since the reset. */
static void judge_gap(hw_onewire *w, uint64_t now) {
    const hw_onewire_timing *t = &w->timing;
    uint64_t rose = w->rose > w->line_rose ? w->rose : w->line_rose;
    uint64_t idle = w->holding ? 0 : now - rose;
    if (w->slot_open) {
        seen(w, HW_OW_SLOT, now - w->fell, now - w->fell < t->slot + t->recovery);
        seen(w, HW_OW_RECOVERY, idle, idle < t->recovery);
    } else if (w->reset_ended) {
        uint64_t high = now - w->reset_ended;
        seen(w, HW_OW_RESET_HIGH, high, high < t->reset_high);
    }
}

static void begin_slot(hw_onewire *w, uint64_t now) {
    judge_gap(w, now);
    w->slot_open = 1;
    w->seen_sample = 0;
    w->fell = now;
    w->sending = sends(w);
    if (w->sending && !bit_to_send(w)) {
        hold(w, 1);
        timer_set(w->release, now + w->timing.hold);
    }
}

static void reset(hw_onewire *w, uint64_t now, uint64_t low) {
    seen(w, HW_OW_RESET_LOW, low, 0);
    w->resets++;
    w->reset_ended = now;
    w->slot_open = 0;
    w->first = 1;
    hw_onewire_receive(w, 8);
    timer_set(w->presence, now + w->timing.presence_wait);
}

static void on_edge(void *param, int low, uint64_t now) {
    hw_onewire *w = param;
    uint64_t lasted = now - w->fell;
    if (!w->connected)
        return;
    if (low) {
        begin_slot(w, now);
        return;
    }
    w->rose = now;
    if (lasted >= w->timing.reset_low) {
        reset(w, now, lasted);
    } else if (lasted > 2 * w->timing.zero_most) {  /* neither a reset nor a bit */
        seen(w, HW_OW_RESET_LOW, lasted, 1);
        w->mode = IGNORE;
    } else {
        end_slot(w, lasted);
    }
}

static void on_sampled(void *param, uint64_t now) {
    hw_onewire *w = param;
    if (!w->connected || !w->slot_open || !w->sending || w->seen_sample || w->rose < w->fell)
        return;
    w->seen_sample = 1;
    seen(w, HW_OW_READ_AT, now - w->fell, now - w->fell > w->timing.read_within);
}

hw_onewire *hw_onewire_new(hw *h, int pin, void *handle, const hw_onewire_timing *timing) {
    hw_onewire *w = chip_new(h, &h->wire_count, HW_WIRES, sizeof *w);
    if (!w)
        return NULL;
    w->h = h;
    w->pin = pin;
    w->handle = handle;
    w->timing = *timing;
    w->connected = 1;
    checks_start(w->checks, HW_OW_CHECKS);
    w->presence = timer_new(h, on_presence, w);
    w->release = timer_new(h, on_release, w);
    struct wire_listener listener = {on_edge, on_sampled, w};
    return w->presence && w->release && !pin_listen(h, pin, listener) ? w : NULL;
}

void hw_onewire_retime(hw_onewire *w, const hw_onewire_timing *timing) { w->timing = *timing; }

void hw_onewire_connect(hw_onewire *w, int connected) {
    w->connected = connected;
    w->slot_open = 0;
    w->mode = IGNORE;
    timer_stop(w->presence);
    timer_stop(w->release);
    hold(w, 0);
}

void hw_onewire_ignore(hw_onewire *w) { w->mode = IGNORE; }

static void begin(hw_onewire *w, enum mode mode, int bits) {
    w->mode = mode;
    w->bits = bits;
    w->position = 0;
}

void hw_onewire_receive(hw_onewire *w, int bits) {
    begin(w, RECEIVE, bits);
    memset(w->data, 0, sizeof w->data);
}

void hw_onewire_send(hw_onewire *w, const uint8_t *data, int bits) {
    begin(w, SEND, bits);
    memcpy(w->data, data, (size_t)(bits + 7) / 8);
}

void hw_onewire_busy(hw_onewire *w, uint64_t until) {
    begin(w, BUSY, 0);
    w->busy_until = until;
}

void hw_onewire_search(hw_onewire *w, const uint8_t *rom) {
    begin(w, SEARCH, 0);
    memcpy(w->data, rom, 8);
}

const hw_check *hw_onewire_checks(hw_onewire *w) { return w->checks; }
uint64_t hw_onewire_resets(hw_onewire *w) { return w->resets; }
