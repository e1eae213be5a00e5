/* UARTs: what is sent with its times, what is received at the line's own speed. */
#include <stdlib.h>
#include <string.h>
#include "hw.h"

#define UPM1 0x20               /* UCSRnC: parity on */
#define USBS 0x08               /* UCSRnC: two stop bits */
#define URSEL 0x80              /* UCSRC: this is UCSRC, not UBRRH */
#define BUFFERED 2              /* bytes the part's receiver holds */

/* On the oldest parts UCSRC and UBRRH share an address, and bit 7 tells which is written. */
static int shared(const avr_uart_t *io) { return io->r_ucsrc == io->ubrrh.reg; }

static void keep_shared(struct uart *u, avr_io_addr_t a, uint8_t v) {
    if (!shared(u->io) || a != u->io->r_ucsrc)
        return;
    if (v & URSEL)
        u->format = v;
    else
        u->divisor_high = v & 0x0f;
}

/* simavr counts a parity bit in every frame and looks only when UBRRnL is written. */
static void refresh(struct uart *u) {
    static const int data_bits[] = {5, 6, 7, 8, 8, 8, 8, 9};
    avr_t *avr = u->h->avr;
    avr_uart_t *io = u->io;
    uint8_t format = shared(io) ? u->format : avr->data[io->r_ucsrc];
    int high = shared(io) ? u->divisor_high : avr_regbit_get(avr, io->ubrrh);
    int divisor = avr_regbit_get(avr, io->ubrrl) | high << 8;
    int bit = (divisor + 1) * (avr_regbit_get(avr, io->u2x) ? 8 : 16);
    int data = data_bits[(format >> 1 & 3) | avr_regbit_get(avr, io->ucsz2) << 2];
    int parity = format & UPM1 ? 1 : 0;
    int stop = 1 + (format & USBS ? 1 : 0);
    u->frame_cycles = bit * (1 + data + parity + stop);
    io->cycles_per_byte = (avr_cycle_count_t)u->frame_cycles;
}

/* What simavr's flags need to be cleared although they are sticky. */
static void clear(struct uart *u, avr_int_vector_t *vector) {
    avr_clear_interrupt_if(u->h->avr, vector, 0);
    avr_regbit_clear(u->h->avr, vector->raised);
}

/* simavr takes the buffer as free when the interrupt is enabled. */
static void on_setting(struct uart *u, struct tap *tap, avr_io_addr_t a, uint8_t v) {
    if (tap->write)
        tap->write(u->h->avr, a, v, tap->write_param);
    else
        u->h->avr->data[a] = v;
    keep_shared(u, a, v);
    refresh(u);
    if (u->buffer_free->armed)
        clear(u, &u->io->udrc);
}

#define SETTING(n) \
    static void on_setting_##n(struct avr_t *avr, avr_io_addr_t a, uint8_t v, void *param) { \
        struct uart *u = param; \
        (void)avr; \
        on_setting(u, &u->taps[n], a, v); \
    }
SETTING(0) SETTING(1) SETTING(2) SETTING(3) SETTING(4)

/* The cycle from which on the buffer takes another byte. */
static uint64_t free_at(struct uart *u) {
    uint64_t frame = (uint64_t)u->frame_cycles;
    return u->busy_until > frame ? u->busy_until - frame : 0;
}

static void on_buffer_free(hw *h, void *param, uint64_t when) {
    struct uart *u = param;
    (void)when;
    avr_raise_interrupt(h->avr, &u->io->udrc);
}

static void on_sent(hw *h, void *param, uint64_t when) {
    struct uart *u = param;
    (void)when;
    avr_raise_interrupt(h->avr, &u->io->txc);
}

/* The part has a buffer before its shift register; simavr frees it a frame late. */
static void on_data(struct avr_t *avr, avr_io_addr_t a, uint8_t value, void *param) {
    struct uart *u = param;
    uint64_t now = avr->cycle;
    (void)a;
    if (!avr_regbit_get(avr, u->io->txen))
        return;
    hw_uart_byte *b = log_add(u->h, HW_UART_LOG);
    b->written = now;
    b->uart = (uint8_t)u->index;
    b->value = value;
    if (u->busy_until > now && free_at(u) > now) {
        b->lost = 1;
        u->overruns++;
        return;
    }
    u->busy_until = (u->busy_until > now ? u->busy_until : now) + (uint64_t)u->frame_cycles;
    b->end = u->busy_until;
    clear(u, &u->io->udrc);
    timer_set(u->buffer_free, free_at(u) > now ? free_at(u) : now + 1);
    timer_set(u->all_sent, u->busy_until);
}

static void on_line(hw *h, void *param, uint64_t when) {
    struct uart *u = param;
    (void)when;
    uint16_t waiting = (uint16_t)((u->io->input.write - u->io->input.read) & 63);
    if (waiting < BUFFERED + 1)
        avr_raise_irq(u->io->io.irq + UART_IRQ_INPUT, u->queue[u->sent]);
    else
        avr_regbit_set(h->avr, u->io->dor);
    if (++u->sent == u->queued)
        return;
    u->next += u->host_frame;
    timer_set(u->line, (uint64_t)u->next);
}

/* A reset ends what is being sent. simavr enables the transmitter; the part does not. */
static void uart_reset_one(struct uart *u) {
    timer_stop(u->buffer_free);
    timer_stop(u->all_sent);
    u->busy_until = 0;
    u->format = 0x06;
    u->divisor_high = 0;
    avr_regbit_clear(u->h->avr, u->io->txen);
    refresh(u);
}

void uart_init(hw *h) {
    static const avr_io_write_t handlers[] = {on_setting_0, on_setting_1, on_setting_2,
                                              on_setting_3, on_setting_4};
    for (int nth = 0;; nth++) {
        avr_uart_t *io = (avr_uart_t *)io_find(h, "uart", nth);
        int index = io ? io->name - '0' : 0;
        if (!io)
            return;
        if (index < 0 || index >= HW_UARTS)
            continue;
        struct uart *u = &h->uarts[index];
        u->h = h;
        u->index = index;
        u->io = io;
        io->flags = 0;          /* neither sleep when polled nor print */
        avr_io_addr_t settings[] = {io->ubrrl.reg, io->ubrrh.reg, io->r_ucsra, io->r_ucsrb,
                                    io->r_ucsrc};
        for (int i = 0; i < 5; i++) {
            int again = 0;
            for (int j = 0; j < i; j++)
                again |= settings[i] == settings[j];
            if (settings[i] && !again)
                tap_write(h, settings[i], handlers[i], u, &u->taps[i]);
        }
        tap_write(h, io->r_udr, on_data, u, &u->taps[5]);
        u->line = timer_new(h, on_line, u);
        u->buffer_free = timer_new(h, on_buffer_free, u);
        u->all_sent = timer_new(h, on_sent, u);
        uart_reset_one(u);
    }
}

void uart_reset(hw *h) {
    for (int i = 0; i < HW_UARTS; i++)
        if (h->uarts[i].io)
            uart_reset_one(&h->uarts[i]);
}

void uart_free(hw *h) {
    for (int i = 0; i < HW_UARTS; i++)
        free(h->uarts[i].queue);
}

/* Queue bytes for the receiver; the first starts when the line is free. */
void hw_uart_send(hw *h, int uart, const uint8_t *data, size_t size, double cycles_per_frame) {
    struct uart *u = &h->uarts[uart];
    size_t rest = u->queued - u->sent;
    if (!u->io || !size)
        return;
    uint8_t *queue = malloc(rest + size);
    if (!queue)
        abort();
    if (rest)
        memcpy(queue, u->queue + u->sent, rest);
    memcpy(queue + rest, data, size);
    free(u->queue);
    u->queue = queue;
    u->queued = rest + size;
    u->sent = 0;
    u->host_frame = cycles_per_frame;
    if (rest)
        return;
    if (u->next < (double)h->avr->cycle)
        u->next = (double)h->avr->cycle;
    else
        u->next += cycles_per_frame;
    timer_set(u->line, (uint64_t)u->next);
}

size_t hw_uart_unsent(hw *h, int uart) { return h->uarts[uart].queued - h->uarts[uart].sent; }

void hw_uart_unsend(hw *h, int uart) {
    struct uart *u = &h->uarts[uart];
    if (u->queued == u->sent)
        return;
    timer_stop(u->line);
    u->queued = u->sent;
}

double hw_uart_frame_cycles(hw *h, int uart) { return h->uarts[uart].frame_cycles; }
uint64_t hw_uart_overruns(hw *h, int uart) { return h->uarts[uart].overruns; }
