/* What the analysis knows of the world: nothing, but whether interrupts may come now. */
#ifndef STATIC_HARNESS_H
#define STATIC_HARNESS_H

#include <avr/io.h> /* registers, as in what is asserted */
#include <stddef.h> /* size_t */
#include <stdint.h> /* uint8_t */

extern __volatile__ uint8_t unknown_byte;
extern uint8_t interrupts_on;

/* Where the text that was made or found last ends, by which texts are told apart. */
extern size_t text_end;
size_t Frama_C_offset(const void *place);
#define ENDS(place) (text_end = Frama_C_offset(place))

/* What was found last in a table, and how many were asked for. */
extern uint8_t told;
extern uint8_t found_entry;
extern uint16_t found_address;
extern uint16_t found_count;

/*@ assigns \result \from unknown_byte;
    ensures \is_finite(\result); */
float any_finite(void);

/* A number of a line of G-code: its reader takes seven digits before the point at most. */
/*@ assigns \result \from number;
    ensures \is_finite(\result) && -1.0e7 < \result < 1.0e7; */
float seven_digits(float number);

/* Any of a group's interrupts that are enabled, any number of times, in any order. */
#define POINT(group) if (interrupts_on) { interrupts_##group(); }

#endif
