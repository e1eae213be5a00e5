/* Snapshots: a RAM range copied whenever a counter has changed as the CPU goes to sleep, or comes to
   an address of the code. After power-on and reset the counter is expected at 0. */
#include <string.h>
#include "fast.h"

static uint32_t counter(const uint8_t *ram, const struct snapshot *s) {
    uint32_t value = 0;
    for (int i = 0; i < s->counter_size; i++)
        value |= (uint32_t)ram[s->counter + i] << 8 * i;
    return value;
}

void snapshots_take(hw *h, uint32_t at) {
    const uint8_t *ram = h->avr->data;
    for (int i = 0; i < h->snapshot_count; i++) {
        struct snapshot *s = &h->snapshots[i];
        uint32_t now = counter(ram, s);
        if (s->at != at || now == s->last)
            continue;
        s->last = now;
        uint8_t *entry = log_add(h, HW_SNAPSHOT_LOG + i);
        memcpy(entry, &h->avr->cycle, sizeof(uint64_t));
        memcpy(entry + sizeof(uint64_t), ram + s->base, s->size);
    }
}

void snapshots_reset(hw *h) {
    for (int i = 0; i < h->snapshot_count; i++)
        h->snapshots[i].last = 0;
}

/* Returns the number of the log that receives the copies, or -1. */
int hw_snapshot(hw *h, uint16_t counter_address, uint8_t counter_size, uint16_t base,
                uint16_t size, uint32_t at) {
    if (at != HW_AT_SLEEP && !fast_mark(h, at))
        return -1;
    if (h->snapshot_count == HW_SNAPSHOTS || counter_size > 4 ||
        base + size > h->avr->ramend + 1 || counter_address + counter_size > h->avr->ramend + 1)
        return -1;
    int i = h->snapshot_count++;
    struct snapshot *s = &h->snapshots[i];
    *s = (struct snapshot){.counter = counter_address, .counter_size = counter_size, .at = at,
                           .base = base, .size = size};
    h->logs[HW_SNAPSHOT_LOG + i].record = sizeof(uint64_t) + size;
    return HW_SNAPSHOT_LOG + i;
}
