/* Builds instructions to a touch display piece by piece; three bytes of 0xFF end each one. */
#include "nextion_say.h"

#include <avr/pgmspace.h> /* pgm_read_byte */

#include "nextion_port.h" /* nextion_port_put, nextion_port_send */
#include "text.h"         /* text_number */

enum { END_SIZE = 3, SAY_SIZE = NEXTION_PORT_SIZE - END_SIZE, END = 0xFF, DIGITS = 10 };

static uint8_t length; /* length of the instruction so far */

void say_char(char character)
{
    if (length < SAY_SIZE) {
        nextion_port_put(length, character);
        length++;
    }
}

void say_stored(const char *words, uint8_t most)
{
    for (char next; most != 0 && (next = (char)pgm_read_byte(words)) != '\0'; words++) {
        say_char(next);
        most--;
    }
}

void say_words(const char *words)
{
    say_stored(words, SAY_SIZE);
}

void say_digits(uint32_t count, uint8_t places)
{
    char digits[DIGITS];
    uint8_t size = 0;

    while (count != 0 || size < places) {
        digits[size] = (char)('0' + (char)(count % 10u));
        count /= 10u;
        size++;
    }
    while (size-- != 0) {
        say_char(digits[size]);
    }
}

/* Appends the sign, and returns the number without it. */
static uint32_t say_sign(int32_t number)
{
    if (number < 0) {
        say_char('-');
        return 0u - (uint32_t)number;
    }
    return (uint32_t)number;
}

void say_number(int32_t number)
{
    say_digits(say_sign(number), 1);
}

void say_scaled(int32_t steps, uint8_t decimals, bool short_form)
{
    uint32_t behind = say_sign(steps);
    uint32_t scale = 1;

    for (uint8_t i = 0; i < decimals; i++) {
        scale *= 10u;
    }
    say_digits(behind / scale, 1);
    behind %= scale;
    while (short_form && decimals != 0 && behind % 10u == 0) {
        behind /= 10u;
        decimals--;
    }
    if (decimals != 0) {
        say_char('.');
        say_digits(behind, decimals);
    }
}

void say_float(float number)
{
    char text[TEXT_SIZE];
    const uint8_t decimals = number < 10.0f ? 6u : number < 1000.0f ? 4u : number < 100000.0f ? 2u : 0u;
    uint8_t size = text_number(text, number, decimals);

    while (decimals != 0 && size > 1 && text[size - 1u] == '0') {
        size--;
    }
    if (decimals != 0 && size > 1 && text[size - 1u] == '.') {
        size--;
    }
    for (uint8_t i = 0; i < size; i++) {
        say_char(text[i]);
    }
}

void say_text(const char *text, uint8_t most)
{
    for (uint8_t i = 0; i < most && text[i] != '\0'; i++) {
        say_char(text[i]);
    }
}

void say_end(void)
{
    if (length > SAY_SIZE) {
        length = SAY_SIZE; /* RAM may be damaged */
    }
    for (uint8_t i = 0; i < END_SIZE; i++) {
        nextion_port_put(length, (char)END);
        length++;
    }
    nextion_port_send(length);
    length = 0;
}
