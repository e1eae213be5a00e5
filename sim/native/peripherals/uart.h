/* Shared by a UART's transmitter, receiver and registers. */
#pragma once

#include <simavr/avr_uart.h>
#include "core/hw.h"

#define HW_UARTS 4

/* What comes to a UART: each character's bits, the start bit first, and when. */
struct character {
    double start, bit;          /* cycles */
    uint16_t levels;
    uint8_t bits;
};
struct line {
    struct character *queue;
    size_t first, count;
    double free;                /* the cycle from which on another may be sent */
};

#define RECEIVED 3              /* two in the buffer, and one in the shift register */
struct received {
    uint16_t value;
    uint8_t framing, parity;    /* errors */
};
struct receiver {
    int on, count, overrun;
    struct received buffer[RECEIVED];
    double from;                /* the cycle since which it looks for a start bit */
    double first;               /* the cycle of the start bit's first low sample */
    int samples, period, data, parity;  /* the format of the character that arrives */
    struct timer *timer;
};

struct uart {
    hw *h;
    int index;
    avr_uart_t *io;
    uint8_t format, divisor_high;       /* UCSRC, UBRRH */
    uint64_t shared_read;               /* last read of the address that both share, cycle */
    uint64_t begins, ends;      /* of the last character sent, cycles */
    uint64_t overruns;          /* bytes lost */
    struct timer *buffer_free, *all_sent;
    struct line line;
    struct receiver receiver;
};

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
/* uart_format.c */
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
