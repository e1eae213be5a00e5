/* What the analysis knows of the world: nothing, but whether interrupts may come now. */
#ifndef STATIC_HARNESS_H
#define STATIC_HARNESS_H

#include <avr/io.h> /* registers, as in what is asserted */
#include <stdint.h> /* uint8_t */

extern __volatile__ uint8_t unknown_byte;
extern uint8_t interrupts_on;

/* Any of the interrupts that are enabled, any number of times, in any order. */
void interrupts(void);

#define POINT if (interrupts_on) { interrupts(); }

#endif
