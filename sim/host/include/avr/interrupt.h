/* Stand-in for avr-libc: an interrupt routine is a function that the world calls. */
#ifndef HOST_INTERRUPT_H
#define HOST_INTERRUPT_H

#define ISR(vector) \
    void vector(void); \
    void vector(void)

#endif
