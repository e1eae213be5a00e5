/* The smallest program that has all that a build reports: code, both kinds of variables, calls,
 * an interrupt and a library routine. */
#include <avr/interrupt.h>
#include <avr/io.h>

#include "level.h"

static volatile float mean = 1.5f;
static volatile uint16_t ticks;

ISR(TIMER1_OVF_vect)
{
    ticks++;
}

int main(void)
{
    sei();
    for (;;)
        mean = level(mean);
}
