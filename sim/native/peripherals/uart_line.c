/* The line to a UART's receiver: the characters from outside, bit by bit, with their own bit times.
   It idles high; characters that come while the receiver is off are lost. */
#include <stdlib.h>
#include <string.h>
#include "uart.h"

static double end_of(const struct character *c) { return c->start + c->bits * c->bit; }
static int bit_of(const struct character *c, int bit) { return c->levels >> bit & 1; }

/* The level at a time in the past, or at a time that can no longer change. */
int line_level(const struct line *l, double time) {
    for (size_t i = l->first; i < l->count && l->queue[i].start <= time; i++)
        if (time < end_of(&l->queue[i]))
            return bit_of(&l->queue[i], (int)((time - l->queue[i].start) / l->queue[i].bit));
    return 1;
}

static int level_before(const struct line *l, size_t i) {
    if (i == l->first || end_of(&l->queue[i - 1]) != l->queue[i].start)
        return 1;
    return bit_of(&l->queue[i - 1], l->queue[i - 1].bits - 1);
}

/* The time of the next fall; negative: none in the characters so far. */
double line_fall(const struct line *l, double from) {
    for (size_t i = l->first; i < l->count; i++) {
        const struct character *c = &l->queue[i];
        if (end_of(c) <= from)
            continue;
        for (int bit = 0, before = level_before(l, i); bit < c->bits; bit++) {
            if (before && !bit_of(c, bit) && c->start + bit * c->bit >= from)
                return c->start + bit * c->bit;
            before = bit_of(c, bit);
        }
    }
    return -1;
}

/* Drop characters before a time; the last one may still be needed. */
void line_forget(struct line *l, double before) {
    while (l->first + 1 < l->count && l->queue[l->first + 1].start <= before)
        l->first++;
}

static void make_room(struct line *l, size_t more) {
    size_t rest = l->count - l->first;
    struct character *queue = malloc((rest + more) * sizeof *queue);
    if (!queue)
        abort();
    if (rest)
        memcpy(queue, l->queue + l->first, rest * sizeof *queue);
    free(l->queue);
    l->queue = queue;
    l->first = 0;
    l->count = rest;
}

/* Each character follows the one before after its gap; the first one when the line is free. */
void line_add(struct line *l, double now, const hw_uart_character *characters, size_t count) {
    make_room(l, count);
    for (size_t i = 0; i < count; i++) {
        const hw_uart_character *c = &characters[i];
        double start = (l->free > now ? l->free : now) + c->gap;
        struct character *added = &l->queue[l->count++];
        *added = (struct character){start, c->bit, c->levels, c->bits};
        l->free = end_of(added);
    }
}

/* Number of characters that have not begun. */
size_t line_waiting(const struct line *l, double now) {
    size_t low = l->first, high = l->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (l->queue[middle].start > now)
            high = middle;
        else
            low = middle + 1;
    }
    return l->count - low;
}

void line_cut(struct line *l, double now) {
    l->count -= line_waiting(l, now);
    l->free = l->count > l->first ? end_of(&l->queue[l->count - 1]) : now;
}
