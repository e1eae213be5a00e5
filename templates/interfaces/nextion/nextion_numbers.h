/* Numbers in what a touch display sends: digits, perhaps a point, nothing else. */
#ifndef NEXTION_NUMBERS_H
#define NEXTION_NUMBERS_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t, int32_t */

/* Each reads a number at `*text` and goes behind it; false: there is none, or it is too large, and
 * what was to be set means nothing. */

/* A whole number from 0 to `most`. */
bool number_whole(const char **text, uint8_t most, uint8_t *number);

/* A number with a sign or not, in steps of 10^-decimals, further digits rounded to nearest. */
bool number_scaled(const char **text, uint8_t decimals, int32_t *steps);

/* The same as a float; further digits than it holds are left out. */
bool number_float(const char **text, float *number);

#endif
