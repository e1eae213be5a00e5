/* Instructions to a touch display, put together piece by piece. */
#ifndef NEXTION_SAY_H
#define NEXTION_SAY_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t, int32_t, uint32_t */

/* The pieces of one instruction; only while the port is free. */
void say_char(char character);
void say_words(const char *words); /* in flash */
void say_count(uint32_t count);
void say_number(int32_t number);

/* `steps` of 10^-decimals, with all decimals, or without the zeros at the end. */
void say_scaled(int32_t steps, uint8_t decimals, bool short_form);

/* Not below 0, with as many digits as a float has, without the zeros at the end. */
void say_float(float number);

/* A name: it has no quotation mark, which would end the text it is put into, and no backslash. */
void say_text(const char *text);

/* Send what was put together. */
void say_end(void);

#endif
