/* UARTs: their registers. Of simavr's UARTs only the interrupts are used: they have no parity, no
   errors, and not the part's buffers and times. */
#include <stdlib.h>
#include "parts.h"
#include "uart.h"

/* On the oldest parts UCSRC and UBRRH share an address, and bit 7 selects which one is written. */
static int shared(const avr_uart_t *io) { return io->r_ucsrc == io->ubrrh.reg; }

/* A set flag requests its interrupt as long as that is enabled. */
static void ask_again(struct uart *u) {
    avr_t *avr = u->h->avr;
    avr_int_vector_t *vectors[] = {&u->io->rxc, &u->io->udrc, &u->io->txc};
    for (int i = 0; i < 3; i++)
        if (avr_regbit_get(avr, vectors[i]->raised) && avr_regbit_get(avr, vectors[i]->enable))
            avr_raise_interrupt(avr, vectors[i]);
}

static void on_return(struct avr_irq_t *irq, uint32_t running, void *param) {
    (void)irq;
    if (!running)
        ask_again(param);
}

static void on_status(struct avr_t *avr, avr_io_addr_t a, uint8_t value, void *param) {
    struct uart *u = param;
    avr->data[a] = (uint8_t)((avr->data[a] & ~U2X) | (value & U2X));
    if (value & TXC)
        uart_clear(u, &u->io->txc);
    if (value & MPCM)
        limit(u->h, "the UART's multi-processor mode is not simulated");
    receiver_again(u);
}

static void on_control(struct avr_t *avr, avr_io_addr_t a, uint8_t value, void *param) {
    struct uart *u = param;
    avr->data[a] = (uint8_t)((avr->data[a] & RXB8) | (value & ~RXB8));
    receiver_switch(u, (value & RXEN) != 0);
    receiver_again(u);
    ask_again(u);
}

static void on_format(struct avr_t *avr, avr_io_addr_t a, uint8_t value, void *param) {
    struct uart *u = param;
    int old = shared(u->io);
    if (old && !(value & URSEL)) {
        avr->data[a] = u->divisor_high = value & 0x0f;
    } else {
        u->format = value;
        if (!old)
            avr->data[a] = value;
        if (value & UMSEL)
            limit(u->h, "the synchronous UART is not simulated");
    }
    receiver_again(u);
}

static void on_divisor(struct avr_t *avr, avr_io_addr_t a, uint8_t value, void *param) {
    struct uart *u = param;
    avr->data[a] = value;
    u->divisor_high = avr->data[u->io->ubrrh.reg] & 0x0f;
    receiver_again(u);
}

static void on_divisor_low(struct avr_t *avr, avr_io_addr_t a, uint8_t value, void *param) {
    avr->data[a] = value;
    receiver_again(param);
}

/* A read of the shared address gives UBRRH; a second read in the next cycle gives UCSRC. */
static uint8_t on_shared_read(struct avr_t *avr, avr_io_addr_t a, void *param) {
    struct uart *u = param;
    int again = u->shared_read && avr->cycle == u->shared_read + 1;
    u->shared_read = avr->cycle;
    return avr->data[a] = again ? u->format | URSEL : u->divisor_high;
}

static void on_data(struct avr_t *avr, avr_io_addr_t a, uint8_t value, void *param) {
    (void)avr, (void)a;
    sender_put(param, value);
}

static uint8_t on_data_read(struct avr_t *avr, avr_io_addr_t a, void *param) {
    return avr->data[a] = receiver_take(param);
}

/* simavr enables the transmitter at a reset; the part does not. */
static void uart_reset_one(struct uart *u) {
    uint8_t *data = u->h->avr->data;
    data[u->io->r_ucsra] = UDRE;
    data[u->io->r_ucsrb] = 0;
    u->format = 0x06;
    u->divisor_high = 0;
    if (!shared(u->io))
        data[u->io->r_ucsrc] = u->format;
    data[u->io->ubrrh.reg] = data[u->io->ubrrl.reg] = 0;
    sender_reset(u);
    receiver_switch(u, 0);
}

static void tap_registers(struct uart *u) {
    avr_uart_t *io = u->io;
    hw *h = u->h;
    struct tap replaced;
    tap_write(h, io->r_ucsra, on_status, u, &replaced);
    tap_read(h, io->r_ucsra, NULL, NULL, &replaced);
    tap_write(h, io->r_ucsrb, on_control, u, &replaced);
    tap_write(h, io->r_ucsrc, on_format, u, &replaced);
    tap_write(h, io->ubrrl.reg, on_divisor_low, u, &replaced);
    tap_write(h, io->r_udr, on_data, u, &replaced);
    tap_read(h, io->r_udr, on_data_read, u, &replaced);
    if (shared(io))
        tap_read(h, io->r_ucsrc, on_shared_read, u, &replaced);
    else
        tap_write(h, io->ubrrh.reg, on_divisor, u, &replaced);
}

void uart_init(hw *h) {
    if (!(h->uarts = calloc(HW_UARTS, sizeof *h->uarts)))
        abort();
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
        tap_registers(u);
        receiver_init(u);
        sender_init(u);
        avr_int_vector_t *vectors[] = {&io->rxc, &io->udrc, &io->txc};
        for (int i = 0; i < 3; i++)
            avr_irq_register_notify(vectors[i]->irq + AVR_INT_IRQ_RUNNING, on_return, u);
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
        free(h->uarts[i].line.queue);
    free(h->uarts);
}

/* Put characters on the line to the receiver, after the waiting ones. */
void hw_uart_send(hw *h, int uart, const hw_uart_character *characters, size_t count) {
    struct uart *u = &h->uarts[uart];
    if (!u->io || !count)
        return;
    line_forget(&u->line, u->receiver.timer->armed ? u->receiver.first : (double)h->avr->cycle);
    line_add(&u->line, (double)h->avr->cycle, characters, count);
    receiver_again(u);
}

size_t hw_uart_unsent(hw *h, int uart) {
    return line_waiting(&h->uarts[uart].line, (double)h->avr->cycle);
}

int hw_uart_exists(hw *h, int uart) {
    return uart >= 0 && uart < HW_UARTS && h->uarts[uart].io;
}

void hw_uart_unsend(hw *h, int uart) {
    struct uart *u = &h->uarts[uart];
    if (!u->io)
        return;
    line_cut(&u->line, (double)h->avr->cycle);
    receiver_again(u);
}
