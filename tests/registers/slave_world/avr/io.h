/* Stand-in for avr-libc: the registers of serial port, timer 2 and pins, as variables (world.c). */
#ifndef WORLD_IO_H
#define WORLD_IO_H

#include <stdint.h>

#ifndef REGISTER
#define REGISTER extern
#endif

REGISTER volatile uint8_t UCSR0A, UCSR0B, UCSR0C, UDR0;
REGISTER volatile uint16_t UBRR0;
REGISTER volatile uint8_t TCCR2A, TCCR2B, TCNT2, OCR2A, TIMSK2, TIFR2;
REGISTER volatile uint8_t PORTA, DDRA, PINA, PORTB, DDRB, PINB, PORTC, DDRC, PINC, PORTD, DDRD,
    PIND, PORTE, DDRE, PINE, PORTF, DDRF, PINF, PORTG, DDRG, PING, PORTH, DDRH, PINH, PORTJ,
    DDRJ, PINJ, PORTK, DDRK, PINK, PORTL, DDRL, PINL;

enum { UPE0 = 2, DOR0 = 3, FE0 = 4, U2X0 = 1, UCSZ00 = 1, UCSZ01 = 2, USBS0 = 3, UPM00 = 4, UPM01 = 5 };
enum { TXEN0 = 3, RXEN0 = 4, TXCIE0 = 6, RXCIE0 = 7 };
enum { CS20 = 0, CS21 = 1, CS22 = 2, OCIE2A = 1, OCF2A = 1 };

#endif
