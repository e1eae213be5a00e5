/* Stand-in for avr-libc: an interrupt is a function that the world calls. */
#ifndef WORLD_INTERRUPT_H
#define WORLD_INTERRUPT_H

#define ISR(vector) \
    void vector(void); \
    void vector(void)

#endif
