/* Stand-in for avr-libc: an interrupt routine is a function that `interrupts` calls. */
#ifndef STATIC_INTERRUPT_H
#define STATIC_INTERRUPT_H

#include "harness.h"

#define ISR(vector) \
    void vector(void); \
    void vector(void)
#define cli() (interrupts_on = 0)
#define sei() (interrupts_on = 1)

#endif
