/* Reads numbers in the commands of a touch display: digits, perhaps a minus and a point. */
#include "nextion_numbers.h"

#include <avr/pgmspace.h> /* PROGMEM */

#include "nextion_frame.h" /* frame_* */

/* A number up to this one and one more digit fit into 32 bits, with the sign. */
static const uint32_t MOST_BEFORE_DIGIT = 99999999UL;

static const float TENS[] PROGMEM = { 1.0f, 10.0f, 100.0f, 1000.0f, 10000.0f, 100000.0f, 1000000.0f };

enum { MOST_DECIMALS = sizeof TENS / sizeof TENS[0] - 1, LAST_DIGIT = 9 };

/* A number as written: its digits without the point, `decimals` of them behind the point. */
struct written {
    uint32_t digits;
    uint8_t decimals;
    bool negative;
};

/* The next character as a digit; above LAST_DIGIT: it is none. */
static uint8_t next_digit(void)
{
    return (uint8_t)(frame_peek() - '0');
}

/* Reads a number with at most `decimals` digits behind the point, rounded by the next digit. */
static bool read(uint8_t decimals, struct written *number)
{
    bool behind_point = false;
    bool any = false;
    bool up = false;
    bool more = false;

    number->digits = 0;
    number->decimals = 0;
    number->negative = frame_skip_if('-');
    while (next_digit() <= LAST_DIGIT || (frame_peek() == '.' && !behind_point)) {
        const uint8_t digit = next_digit();
        frame_skip();
        if (digit > LAST_DIGIT) {
            behind_point = true;
            continue;
        }
        any = true;
        if (number->decimals == decimals) {
            up = more ? up : digit >= 5;
            more = true;
            continue;
        }
        if (number->digits > MOST_BEFORE_DIGIT) {
            return false;
        }
        number->digits = 10u * number->digits + digit;
        if (behind_point) {
            number->decimals++;
        }
    }
    if (up) {
        number->digits++;
    }
    return any;
}

bool number_whole(uint8_t most, uint8_t *number)
{
    uint16_t value = 0;
    uint8_t digit = next_digit();
    const bool any = digit <= LAST_DIGIT;

    for (; digit <= LAST_DIGIT; digit = next_digit()) {
        value = (uint16_t)(10u * value + digit);
        if (value > most) {
            return false;
        }
        frame_skip();
    }
    *number = (uint8_t)value;
    return any;
}

bool number_scaled(uint8_t decimals, int32_t *steps)
{
    struct written number;

    if (!read(decimals, &number)) {
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

bool number_float(float *number)
{
    struct written written;

    if (!read(MOST_DECIMALS, &written)) {
        return false;
    }
    /* Seven digits are exact in a float: only this division rounds, to the nearest float. */
    *number = (float)written.digits / pgm_read_float(&TENS[written.decimals]);
    if (written.negative) {
        *number = -*number;
    }
    return true;
}
