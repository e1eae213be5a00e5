/* Stand-in for avr-libc: the registers of ports and timers as plain variables (world.c). */
#ifndef HOST_IO_H
#define HOST_IO_H

#include <stdint.h> /* uint8_t, uint16_t */

enum { HOST_PORTS = 11, HOST_TIMERS = 6 };

struct host_timer {
    uint8_t control_a;
    uint8_t control_b;
    uint8_t interrupts;
    uint16_t count;
    uint16_t top;
    uint16_t compare[3];
};

extern volatile uint8_t host_port[HOST_PORTS];
extern volatile uint8_t host_ddr[HOST_PORTS];
/* Returns the levels of a port's pins. */
uint8_t host_level(uint8_t port);

extern volatile struct host_timer host_timer[HOST_TIMERS];

#define PORTA host_port[0]
#define DDRA host_ddr[0]
#define PINA host_level(0)
#define PORTB host_port[1]
#define DDRB host_ddr[1]
#define PINB host_level(1)
#define PORTC host_port[2]
#define DDRC host_ddr[2]
#define PINC host_level(2)
#define PORTD host_port[3]
#define DDRD host_ddr[3]
#define PIND host_level(3)
#define PORTE host_port[4]
#define DDRE host_ddr[4]
#define PINE host_level(4)
#define PORTF host_port[5]
#define DDRF host_ddr[5]
#define PINF host_level(5)
#define PORTG host_port[6]
#define DDRG host_ddr[6]
#define PING host_level(6)
#define PORTH host_port[7]
#define DDRH host_ddr[7]
#define PINH host_level(7)
#define PORTJ host_port[8]
#define DDRJ host_ddr[8]
#define PINJ host_level(8)
#define PORTK host_port[9]
#define DDRK host_ddr[9]
#define PINK host_level(9)
#define PORTL host_port[10]
#define DDRL host_ddr[10]
#define PINL host_level(10)

#define TCCR0A host_timer[0].control_a
#define TCCR0B host_timer[0].control_b
#define TIMSK0 host_timer[0].interrupts
#define OCIE0A 1
#define OCIE0B 2
#define OCIE0C 3
#define TCNT0 host_timer[0].count
#define ICR0 host_timer[0].top
#define OCR0A host_timer[0].compare[0]
#define COM0A1 7
#define COM0A0 6
#define OCR0B host_timer[0].compare[1]
#define COM0B1 5
#define COM0B0 4
#define OCR0C host_timer[0].compare[2]
#define COM0C1 3
#define COM0C0 2
#define WGM00 0
#define WGM01 1
#define WGM02 3
#define WGM03 4
#define CS00 0
#define CS01 1
#define CS02 2

#define TCCR1A host_timer[1].control_a
#define TCCR1B host_timer[1].control_b
#define TIMSK1 host_timer[1].interrupts
#define OCIE1A 1
#define OCIE1B 2
#define OCIE1C 3
#define TCNT1 host_timer[1].count
#define ICR1 host_timer[1].top
#define OCR1A host_timer[1].compare[0]
#define COM1A1 7
#define COM1A0 6
#define OCR1B host_timer[1].compare[1]
#define COM1B1 5
#define COM1B0 4
#define OCR1C host_timer[1].compare[2]
#define COM1C1 3
#define COM1C0 2
#define WGM10 0
#define WGM11 1
#define WGM12 3
#define WGM13 4
#define CS10 0
#define CS11 1
#define CS12 2

#define TCCR2A host_timer[2].control_a
#define TCCR2B host_timer[2].control_b
#define TIMSK2 host_timer[2].interrupts
#define OCIE2A 1
#define OCIE2B 2
#define OCIE2C 3
#define TCNT2 host_timer[2].count
#define ICR2 host_timer[2].top
#define OCR2A host_timer[2].compare[0]
#define COM2A1 7
#define COM2A0 6
#define OCR2B host_timer[2].compare[1]
#define COM2B1 5
#define COM2B0 4
#define OCR2C host_timer[2].compare[2]
#define COM2C1 3
#define COM2C0 2
#define WGM20 0
#define WGM21 1
#define WGM22 3
#define WGM23 4
#define CS20 0
#define CS21 1
#define CS22 2

#define TCCR3A host_timer[3].control_a
#define TCCR3B host_timer[3].control_b
#define TIMSK3 host_timer[3].interrupts
#define OCIE3A 1
#define OCIE3B 2
#define OCIE3C 3
#define TCNT3 host_timer[3].count
#define ICR3 host_timer[3].top
#define OCR3A host_timer[3].compare[0]
#define COM3A1 7
#define COM3A0 6
#define OCR3B host_timer[3].compare[1]
#define COM3B1 5
#define COM3B0 4
#define OCR3C host_timer[3].compare[2]
#define COM3C1 3
#define COM3C0 2
#define WGM30 0
#define WGM31 1
#define WGM32 3
#define WGM33 4
#define CS30 0
#define CS31 1
#define CS32 2

#define TCCR4A host_timer[4].control_a
#define TCCR4B host_timer[4].control_b
#define TIMSK4 host_timer[4].interrupts
#define OCIE4A 1
#define OCIE4B 2
#define OCIE4C 3
#define TCNT4 host_timer[4].count
#define ICR4 host_timer[4].top
#define OCR4A host_timer[4].compare[0]
#define COM4A1 7
#define COM4A0 6
#define OCR4B host_timer[4].compare[1]
#define COM4B1 5
#define COM4B0 4
#define OCR4C host_timer[4].compare[2]
#define COM4C1 3
#define COM4C0 2
#define WGM40 0
#define WGM41 1
#define WGM42 3
#define WGM43 4
#define CS40 0
#define CS41 1
#define CS42 2

#define TCCR5A host_timer[5].control_a
#define TCCR5B host_timer[5].control_b
#define TIMSK5 host_timer[5].interrupts
#define OCIE5A 1
#define OCIE5B 2
#define OCIE5C 3
#define TCNT5 host_timer[5].count
#define ICR5 host_timer[5].top
#define OCR5A host_timer[5].compare[0]
#define COM5A1 7
#define COM5A0 6
#define OCR5B host_timer[5].compare[1]
#define COM5B1 5
#define COM5B0 4
#define OCR5C host_timer[5].compare[2]
#define COM5C1 3
#define COM5C0 2
#define WGM50 0
#define WGM51 1
#define WGM52 3
#define WGM53 4
#define CS50 0
#define CS51 1
#define CS52 2

#if defined(__AVR_ATmega16__) || defined(__AVR_ATmega32__)
#include <avr/io_old.h>
#endif

#endif
