/* Other names on the ATmega16 and 32: one TIMSK, and one control register per 8-bit timer. */
#ifndef HOST_IO_OLD_H
#define HOST_IO_OLD_H

#define TIMSK host_timer[0].interrupts
#define OCIE1A 4
#define OCIE1B 3
#define TCCR0 host_timer[0].control_a
#define OCR0 host_timer[0].compare[0]
#define WGM00 6
#define COM01 5
#define COM00 4
#define WGM01 3
#define TCCR2 host_timer[2].control_a
#define OCR2 host_timer[2].compare[0]
#define WGM20 6
#define COM21 5
#define COM20 4
#define WGM21 3

#endif
