/* A UART's transmitter: a buffer and a shift register; sent bytes are logged with their times. */
#include "uart.h"

static int frame_cycles(struct uart_format f) {
    return f.period * f.samples * (1 + f.data + (f.parity != PARITY_NONE) + f.stop);
}

double hw_uart_frame_cycles(hw *h, int uart) {
    return frame_cycles(uart_format(&h->uarts[uart]));
}

uint64_t hw_uart_overruns(hw *h, int uart) { return h->uarts[uart].overruns; }

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

/* The format byte of the log: see hw_uart_byte. */
static uint8_t format_byte(struct uart_format f, uint8_t ninth) {
    return (uint8_t)(f.data | f.parity << 4 | (f.stop == 2 ? 0x40 : 0) | (ninth ? 0x80 : 0));
}

/* Write UDR. The byte moves to the shift register when that is free, which frees the buffer. */
void sender_put(struct uart *u, uint8_t value) {
    avr_t *avr = u->h->avr;
    uint64_t now = avr->cycle;
    struct uart_format f = uart_format(u);
    uint8_t control = avr->data[u->io->r_ucsrb];
    if (!(control & TXEN))
        return;
    hw_uart_byte *b = log_add(u->h, HW_UART_LOG);
    b->written = now;
    b->uart = (uint8_t)u->index;
    b->value = value;
    b->format = format_byte(f, f.data == 9 ? control & TXB8 : 0);
    b->bit_cycles = (uint32_t)(f.period * f.samples);
    if (u->begins > now) {
        b->lost = 1;
        u->overruns++;
        return;
    }
    u->begins = u->ends > now ? u->ends : now;
    u->ends = u->begins + (uint64_t)frame_cycles(f);
    b->end = u->ends;
    uart_clear(u, &u->io->udrc);
    timer_set(u->buffer_free, u->begins > now ? u->begins : now + 1);
    timer_set(u->all_sent, u->ends);
}

/* A reset aborts the character that is being sent. */
void sender_reset(struct uart *u) {
    timer_stop(u->buffer_free);
    timer_stop(u->all_sent);
    u->begins = u->ends = 0;
}

void sender_init(struct uart *u) {
    u->buffer_free = timer_new(u->h, on_buffer_free, u);
    u->all_sent = timer_new(u->h, on_sent, u);
}
