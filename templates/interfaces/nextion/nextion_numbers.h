/* Reads numbers in the commands of a touch display: digits, perhaps a minus and a point. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t, int32_t */

/* Each function reads the number that is next in the command, up to the character behind it. False:
 * there is no number, or it is too large; then the result is not valid. */

/* A whole number from 0 to `most`. */
bool number_whole(uint8_t most, uint8_t *number);

/* A number, also with a minus, in steps of 10^-decimals; further digits are rounded to nearest. */
bool number_scaled(uint8_t decimals, int32_t *steps);

/* Like number_scaled, but as a float; the number is rounded to six decimals. */
bool number_float(float *number);
