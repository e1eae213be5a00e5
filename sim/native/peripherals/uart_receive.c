/* A UART's receiver: it samples the line in the middle of each bit by its own clock, so a character
   with another baud rate or format is received as on the part. */
#include "uart.h"

static const int vote_16[] = {8, 9, 10}, vote_8[] = {4, 5, 6};  /* samples, from 1 */

static double up(double value) {
    double whole = (double)(uint64_t)value;
    return whole < value ? whole + 1 : whole;
}

static double sample_time(const struct receiver *r, int bit, int sample) {
    return r->first + (bit * r->samples + sample - 1) * r->period;
}

static const int *votes(const struct receiver *r) { return r->samples == 8 ? vote_8 : vote_16; }

static double stop_time(const struct receiver *r, int vote) {
    return sample_time(r, 1 + r->data + (r->parity != PARITY_NONE), votes(r)[vote]);
}

/* Bit 0 is the start bit. */
static int sampled(const struct uart *u, int bit) {
    int high = 0;
    for (int n = 0; n < 3; n++)
        high += line_level(&u->line, sample_time(&u->receiver, bit, votes(&u->receiver)[n]));
    return high >= 2;
}

/* Wait for the next start bit; its first low sample fixes all times of the character. */
static void seek(struct uart *u, double from) {
    struct receiver *r = &u->receiver;
    timer_stop(r->timer);
    r->from = from;
    line_forget(&u->line, from);
    double fall = r->on ? line_fall(&u->line, from) : -1;
    if (fall < 0)
        return;
    struct uart_format f = uart_format(u);
    r->samples = f.samples;
    r->period = f.period;
    r->data = f.data;
    r->parity = f.parity;
    r->first = up(fall / r->period) * r->period;
    timer_set(r->timer, (uint64_t)up(stop_time(r, 2)));
}

/* Set the flags for the next character in the buffer, if there is one. */
static void show(struct uart *u) {
    struct receiver *r = &u->receiver;
    uint8_t *data = u->h->avr->data;
    const struct received *head = &r->buffer[0];
    uint8_t flags = (uint8_t)((r->count && head->framing ? FE : 0) |
                              (r->count && head->parity ? UPE : 0) | (r->overrun ? DOR : 0));
    uint8_t ninth = r->count && head->value >> 8 ? RXB8 : 0;
    data[u->io->r_ucsra] = (uint8_t)((data[u->io->r_ucsra] & ~(FE | UPE | DOR)) | flags);
    data[u->io->r_ucsrb] = (uint8_t)((data[u->io->r_ucsrb] & ~RXB8) | ninth);
    if (r->count)
        avr_raise_interrupt(u->h->avr, &u->io->rxc);
    else
        uart_clear(u, &u->io->rxc);
}

static struct received decoded(const struct uart *u) {
    const struct receiver *r = &u->receiver;
    struct received c = {0};
    int ones = 0, bit = 1;
    for (int n = 0; n < r->data; n++, bit++) {
        int level = sampled(u, bit);
        c.value |= (uint16_t)(level << n);
        ones += level;
    }
    if (r->parity != PARITY_NONE)
        c.parity = ((ones + sampled(u, bit++)) & 1) != (r->parity == PARITY_ODD);
    c.framing = !sampled(u, bit);
    return c;
}

/* Called at the last sample of the stop bit, which may already be the next start bit's first one. */
static void on_character(hw *h, void *param, uint64_t when) {
    struct uart *u = param;
    struct receiver *r = &u->receiver;
    (void)h, (void)when;
    if (sampled(u, 0)) {                        /* no start bit but a disturbance */
        seek(u, sample_time(r, 0, r->samples));
        return;
    }
    if (r->count == RECEIVED)
        r->overrun = 1;
    else
        r->buffer[r->count++] = decoded(u);
    show(u);
    seek(u, stop_time(r, 1));
}

/* Read UDR. */
uint8_t receiver_take(struct uart *u) {
    struct receiver *r = &u->receiver;
    uint8_t value = (uint8_t)r->buffer[0].value;
    if (!r->count)
        return value;
    r->count--;
    r->overrun = 0;
    for (int i = 0; i < r->count; i++)
        r->buffer[i] = r->buffer[i + 1];
    show(u);
    return value;
}

/* When switched on it waits for an edge; when switched off it empties its buffer. */
void receiver_switch(struct uart *u, int on) {
    struct receiver *r = &u->receiver;
    if (r->on == on)
        return;
    r->on = on;
    r->count = r->overrun = 0;
    show(u);
    seek(u, (double)u->h->avr->cycle);
}

/* The settings or the line have changed: a character that has begun to arrive continues. If none has
   begun, there was no start bit up to now. */
void receiver_again(struct uart *u) {
    struct receiver *r = &u->receiver;
    double now = (double)u->h->avr->cycle;
    if (!r->timer->armed)
        seek(u, r->from > now ? r->from : now);
    else if (r->first > now)
        seek(u, r->from);
}

void receiver_init(struct uart *u) { u->receiver.timer = timer_new(u->h, on_character, u); }
