/* Numbers as text, without printf. */

#include <stdint.h> /* uint8_t */

enum { TEXT_SIZE = 13 }; /* "-20000000.00" and the closing 0 */

/* Write `value` with `decimals` digits behind the point, rounded half away from zero, and a
 * closing 0; values beyond 20 million are written as 20 million. Returns the length. */
uint8_t text_number(char text[TEXT_SIZE], float value, uint8_t decimals);
