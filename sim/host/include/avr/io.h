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
#define TCNT0 host_timer[0].count
#define ICR0 host_timer[0].top
#define OCR0A host_timer[0].compare[0]
#define OCR0B host_timer[0].compare[1]
#define OCR0C host_timer[0].compare[2]

#define TCCR1A host_timer[1].control_a
#define TCCR1B host_timer[1].control_b
#define TIMSK1 host_timer[1].interrupts
#define TCNT1 host_timer[1].count
#define ICR1 host_timer[1].top
#define OCR1A host_timer[1].compare[0]
#define OCR1B host_timer[1].compare[1]
#define OCR1C host_timer[1].compare[2]

#define TCCR2A host_timer[2].control_a
#define TCCR2B host_timer[2].control_b
#define TIMSK2 host_timer[2].interrupts
#define TCNT2 host_timer[2].count
#define ICR2 host_timer[2].top
#define OCR2A host_timer[2].compare[0]
#define OCR2B host_timer[2].compare[1]
#define OCR2C host_timer[2].compare[2]

#define TCCR3A host_timer[3].control_a
#define TCCR3B host_timer[3].control_b
#define TIMSK3 host_timer[3].interrupts
#define TCNT3 host_timer[3].count
#define ICR3 host_timer[3].top
#define OCR3A host_timer[3].compare[0]
#define OCR3B host_timer[3].compare[1]
#define OCR3C host_timer[3].compare[2]

#define TCCR4A host_timer[4].control_a
#define TCCR4B host_timer[4].control_b
#define TIMSK4 host_timer[4].interrupts
#define TCNT4 host_timer[4].count
#define ICR4 host_timer[4].top
#define OCR4A host_timer[4].compare[0]
#define OCR4B host_timer[4].compare[1]
#define OCR4C host_timer[4].compare[2]

#define TCCR5A host_timer[5].control_a
#define TCCR5B host_timer[5].control_b
#define TIMSK5 host_timer[5].interrupts
#define TCNT5 host_timer[5].count
#define ICR5 host_timer[5].top
#define OCR5A host_timer[5].compare[0]
#define OCR5B host_timer[5].compare[1]
#define OCR5C host_timer[5].compare[2]

/* The bits of a timer's registers: each timer is declared with all bits that any timer has. */
#define TIMER_BITS(n) \
    enum { \
        OCIE##n##A = 1, OCIE##n##B = 2, OCIE##n##C = 3, CS##n##0 = 0, CS##n##1 = 1, CS##n##2 = 2, \
        COM##n##A1 = 7, COM##n##A0 = 6, COM##n##B1 = 5, COM##n##B0 = 4, COM##n##C1 = 3, \
        COM##n##C0 = 2, WGM##n##0 = 0, WGM##n##1 = 1, WGM##n##2 = 3, WGM##n##3 = 4 \
    };
TIMER_BITS(0)
TIMER_BITS(1)
TIMER_BITS(2)
TIMER_BITS(3)
TIMER_BITS(4)
TIMER_BITS(5)

#if defined(__AVR_ATmega16__) || defined(__AVR_ATmega32__)
#include <avr/io_old.h>
#endif

#endif
