/* The format that a UART's registers define, and its flags. */
#include "uart.h"

struct uart_format uart_format(const struct uart *u) {
    static const int data_bits[] = {5, 6, 7, 8, 8, 8, 8, 9};
    const uint8_t *data = u->h->avr->data;
    const avr_uart_t *io = u->io;
    uint8_t format = u->format;
    int large = data[io->r_ucsrb] & UCSZ2 ? 4 : 0;
    return (struct uart_format){
        .data = data_bits[(format >> 1 & 3) | large],
        .parity = format >> 4 & 3,
        .stop = format & USBS ? 2 : 1,
        .samples = data[io->r_ucsra] & U2X ? 8 : 16,
        .period = (u->divisor_high << 8 | data[io->ubrrl.reg]) + 1,
    };
}

/* Clear a flag and its interrupt request: simavr keeps sticky flags, so both calls are needed. */
void uart_clear(struct uart *u, avr_int_vector_t *vector) {
    avr_clear_interrupt_if(u->h->avr, vector, 0);
    avr_regbit_clear(u->h->avr, vector->raised);
}
