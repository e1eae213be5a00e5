/* Shared by a UART's transmitter, receiver and registers. */
#ifndef HEATWRIGHT_UART_H
#define HEATWRIGHT_UART_H

#include "hw.h"

/* Bits of UCSRnA, UCSRnB, UCSRnC, the same on all parts. */
enum { RXC = 0x80, TXC = 0x40, UDRE = 0x20, FE = 0x10, DOR = 0x08, UPE = 0x04, U2X = 0x02,
       MPCM = 0x01 };
enum { RXCIE = 0x80, TXCIE = 0x40, UDRIE = 0x20, RXEN = 0x10, TXEN = 0x08, UCSZ2 = 0x04,
       RXB8 = 0x02, TXB8 = 0x01 };
enum { URSEL = 0x80, UMSEL = 0x40, USBS = 0x08 };

enum { PARITY_NONE = 0, PARITY_EVEN = 2, PARITY_ODD = 3 };     /* UPM */

struct uart_format {
    int data, parity, stop;
    int samples;                /* per bit: 16, or 8 at double speed */
    int period;                 /* cycles between two samples */
};
struct uart_format uart_format(const struct uart *u);
void uart_clear(struct uart *u, avr_int_vector_t *vector);

/* uart_line.c */
int line_level(const struct line *l, double time);
double line_fall(const struct line *l, double from);
void line_forget(struct line *l, double before);
void line_add(struct line *l, double now, const hw_uart_character *characters, size_t count);
size_t line_waiting(const struct line *l, double now);
void line_cut(struct line *l, double now);

/* uart_receive.c */
void receiver_init(struct uart *u);
void receiver_switch(struct uart *u, int on);
void receiver_again(struct uart *u);
uint8_t receiver_take(struct uart *u);

/* uart_send.c */
void sender_init(struct uart *u);
void sender_reset(struct uart *u);
void sender_put(struct uart *u, uint8_t value);

#endif
