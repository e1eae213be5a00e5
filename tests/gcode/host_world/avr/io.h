/* Stand-in for avr-libc: the serial port's registers, and those of pins.h, as variables (world.c). */
#ifndef WORLD_IO_H
#define WORLD_IO_H

#include <stdint.h>

#ifndef REGISTER
#define REGISTER extern
#endif

REGISTER volatile uint8_t UCSR0A, UCSR0B, UCSR0C, UDR0;
REGISTER volatile uint16_t UBRR0;
REGISTER volatile uint8_t PORTA, DDRA, PINA, PORTB, DDRB, PINB, PORTC, DDRC, PINC, PORTD, DDRD,
    PIND, PORTE, DDRE, PINE, PORTF, DDRF, PINF, PORTG, DDRG, PING, PORTH, DDRH, PINH, PORTJ,
    DDRJ, PINJ, PORTK, DDRK, PINK, PORTL, DDRL, PINL;

enum { FE0 = 4, DOR0 = 3, U2X0 = 1, UCSZ00 = 1, UCSZ01 = 2, TXEN0 = 3, RXEN0 = 4, UDRIE0 = 5, RXCIE0 = 7 };

#endif
