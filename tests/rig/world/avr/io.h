/* The registers of the serial port as variables, those of timer 2 that the host build lacks, and
 * the rest as in the host build. The world that has them defines REGISTER as nothing. */
#ifndef RIG_IO_H
#define RIG_IO_H

#include_next <avr/io.h>

#ifndef REGISTER
#define REGISTER extern
#endif

REGISTER volatile uint8_t UCSR0A, UCSR0B, UCSR0C, UDR0, UBRR0H, UBRR0L;
REGISTER volatile uint8_t TIFR2;

#define UBRR0 ((unsigned)UBRR0H << 8 | UBRR0L)

enum { MPCM0 = 0, U2X0 = 1, UPE0 = 2, DOR0 = 3, FE0 = 4 };
enum { UCSZ00 = 1, UCSZ01 = 2, USBS0 = 3, UPM00 = 4, UPM01 = 5 };
enum { TXEN0 = 3, RXEN0 = 4, UDRIE0 = 5, TXCIE0 = 6, RXCIE0 = 7 };
enum { OCF2A = 1 };

#endif
