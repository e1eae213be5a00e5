/* The serial port's registers as variables (world.c), and the rest as in the host build. */
#ifndef TOUCH_IO_H
#define TOUCH_IO_H

#include_next <avr/io.h>

#ifndef REGISTER
#define REGISTER extern
#endif

REGISTER volatile uint8_t UCSR0A, UCSR0B, UCSR0C, UDR0;
REGISTER volatile uint16_t UBRR0;

enum { FE0 = 4, DOR0 = 3, U2X0 = 1, UCSZ00 = 1, UCSZ01 = 2, TXEN0 = 3, RXEN0 = 4, UDRIE0 = 5, RXCIE0 = 7 };

#endif
