/* Numbers as text, without printf and without division. */
#include "text.h"

#include <avr/pgmspace.h> /* PROGMEM */
#include <stdbool.h>      /* bool */

static const float LARGEST = 20.0e6f; /* with two decimals it still fits in 32 bits */

enum { PLACES = 10 };
static const uint32_t POWERS[PLACES] PROGMEM
    = { 1UL, 10UL, 100UL, 1000UL, 10000UL, 100000UL, 1000000UL, 10000000UL, 100000000UL, 1000000000UL };

uint8_t text_number(char text[TEXT_SIZE], float value, uint8_t decimals)
{
    bool negative = false;
    uint8_t length = 0;

    if (value < 0.0f) {
        negative = true;
        value = -value;
    }
    if (!(value < LARGEST)) {
        value = LARGEST;
    }
    for (uint8_t i = 0; i < decimals; i++) {
        value *= 10.0f;
    }
    /* Rounds twice the number, which is exact; adding 0.5 is not exact from 2^23 on. */
    uint32_t rest = ((uint32_t)(value + value) + 1u) >> 1;
    if (negative && rest != 0) {
        text[length++] = '-';
    }

    bool leading = true; /* leading zeros are left out, except the one before the point */
    for (uint8_t place = PLACES; place-- != 0;) {
        const uint32_t power = pgm_read_dword(&POWERS[place]);
        char digit = '0';
        while (rest >= power) {
            rest -= power;
            digit++;
        }
        leading = leading && digit == '0' && place > decimals;
        if (leading) {
            continue;
        }
        if (place + 1u == decimals) {
            text[length++] = '.';
        }
        text[length++] = digit;
    }
    text[length] = '\0';
    return length;
}
