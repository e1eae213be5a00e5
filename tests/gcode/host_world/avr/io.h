/* Stand-in for avr-libc: the serial port's registers as variables (world.c). */
#ifndef WORLD_IO_H
#define WORLD_IO_H

#include <stdint.h>

extern volatile uint8_t UCSR0A, UCSR0B, UCSR0C, UDR0, PORTE;
extern volatile uint16_t UBRR0;

enum { FE0 = 4, DOR0 = 3, U2X0 = 1, UCSZ00 = 1, UCSZ01 = 2, TXEN0 = 3, RXEN0 = 4, UDRIE0 = 5, RXCIE0 = 7 };

#endif
