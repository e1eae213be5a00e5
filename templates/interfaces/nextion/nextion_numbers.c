/* Reads numbers in the commands of a touch display: digits, perhaps a minus and a point. */
#include "nextion_numbers.h"

#include <avr/pgmspace.h> /* PROGMEM */

/* A number up to this one and one more digit fit into 32 bits, with the sign. */
static const uint32_t MOST_BEFORE_DIGIT = 99999999UL;

static const float TENS[] PROGMEM = { 1.0f, 10.0f, 100.0f, 1000.0f, 10000.0f, 100000.0f, 1000000.0f };

enum { MOST_DECIMALS = sizeof TENS / sizeof TENS[0] - 1 };

/* A number as written: its digits without the point, `decimals` of them behind the point. */
struct written {
    uint32_t digits;
    uint8_t decimals;
    bool negative;
};

static bool is_digit(char character)
{
    return character >= '0' && character <= '9';
}

/* Reads a number with at most `decimals` digits behind the point, rounded by the next digit. */
static bool read(const char **text, uint8_t decimals, struct written *number)
{
    const char *at = *text;
    bool behind_point = false;
    bool any = false;
    bool up = false;
    bool more = false;

    number->digits = 0;
    number->decimals = 0;
    number->negative = *at == '-';
    if (number->negative) {
        at++;
    }
    for (; is_digit(*at) || (*at == '.' && !behind_point); at++) {
        if (*at == '.') {
            behind_point = true;
            continue;
        }
        any = true;
        if (number->decimals == decimals) {
            up = more ? up : *at >= '5';
            more = true;
            continue;
        }
        if (number->digits > MOST_BEFORE_DIGIT) {
            return false;
        }
        number->digits = 10u * number->digits + (uint32_t)(*at - '0');
        if (behind_point) {
            number->decimals++;
        }
    }
    if (up) {
        number->digits++;
    }
    *text = at;
    return any;
}

bool number_whole(const char **text, uint8_t most, uint8_t *number)
{
    uint16_t value = 0;
    const char *at = *text;

    for (; is_digit(*at); at++) {
        value = (uint16_t)(10u * value + (uint16_t)(*at - '0'));
        if (value > most) {
            return false;
        }
    }
    const bool any = at != *text;
    *text = at;
    *number = (uint8_t)value;
    return any;
}

bool number_scaled(const char **text, uint8_t decimals, int32_t *steps)
{
    struct written number;

    if (!read(text, decimals, &number)) {
        return false;
    }
    for (; number.decimals < decimals; number.decimals++) {
        if (number.digits > MOST_BEFORE_DIGIT) {
            return false;
        }
        number.digits *= 10u;
    }
    *steps = number.negative ? -(int32_t)number.digits : (int32_t)number.digits;
    return true;
}

bool number_float(const char **text, float *number)
{
    struct written written;

    if (!read(text, MOST_DECIMALS, &written)) {
        return false;
    }
    /* Seven digits are exact in a float: only this division rounds, to the nearest float. */
    *number = (float)written.digits / pgm_read_float(&TENS[written.decimals]);
    if (written.negative) {
        *number = -*number;
    }
    return true;
}
