/* Builds instructions to a touch display piece by piece. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t, int32_t, uint32_t */

/* Append a piece to the instruction; only while the port is free. */
void say_char(char character);
void say_words(const char *words);                /* a string in flash */
void say_stored(const char *words, uint8_t most); /* the same, of `most` characters at most */
void say_number(int32_t number);
void say_digits(uint32_t count, uint8_t places); /* at least `places` digits */

/* Append `steps` of 10^-decimals; `short_form` leaves out zeros at the end. */
void say_scaled(int32_t steps, uint8_t decimals, bool short_form);

/* Append a number not below 0, with the digits of a float, without zeros at the end. */
void say_float(float number);

/* Append a name of `most` characters at most; it must not contain a quotation mark, which would end
 * the text, or a backslash. */
void say_text(const char *text, uint8_t most);

/* Send the instruction. */
void say_end(void);
