/* Numbers as text, without printf. */
#include "text.h"

#include <stdbool.h> /* bool */

static const float LARGEST = 20.0e6f; /* a long with two decimals holds it */

static void reverse(char *first, char *last)
{
    while (first < last) {
        const char kept = *first;
        *first++ = *last;
        *last-- = kept;
    }
}

uint8_t text_number(char text[TEXT_SIZE], float value, uint8_t decimals)
{
    const bool negative = value < 0.0f;
    uint8_t length = 0;

    if (negative) {
        value = -value;
    }
    if (!(value < LARGEST)) {
        value = LARGEST;
    }
    for (uint8_t i = 0; i < decimals; i++) {
        value *= 10.0f;
    }
    uint32_t digits = (uint32_t)(value + 0.5f);

    /* From the last digit to the first, with at least one before the point. */
    const bool zero = digits == 0;
    for (uint8_t i = 0; i <= decimals || digits != 0; i++) {
        if (i == decimals && decimals != 0) {
            text[length++] = '.';
        }
        text[length++] = (char)('0' + (char)(digits % 10u));
        digits /= 10u;
    }
    if (negative && !zero) {
        text[length++] = '-';
    }
    text[length] = '\0';
    reverse(text, text + length - 1);
    return length;
}
