/* Reads the words of one line of G-code: a letter and a number, such as S200. */
#include "gcode_words.h"

#include <avr/pgmspace.h> /* PROGMEM */

char words_letter;
uint16_t words_command;

static char text[WORDS_SIZE]; /* no pointer to it is stored, so a flipped bit cannot lead outside */
static uint8_t parameters; /* place behind the command */

static const float TENS[] PROGMEM = { 1.0f, 10.0f, 100.0f, 1000.0f, 10000.0f, 100000.0f, 1000000.0f };

/* Further decimals are read, but ignored. */
enum { MOST_DECIMALS = sizeof TENS / sizeof TENS[0] - 1 };

/* A number may have up to seven digits before its point; one with more is refused. */
static const uint32_t MOST_WHOLE = 9999999;

/* A command number up to this one may have one more digit; the maximum is four digits. */
enum { MOST_BEFORE_DIGIT = 999 };

static bool is_digit(char character)
{
    return character >= '0' && character <= '9';
}

static bool is_blank(char character)
{
    return character == ' ' || character == '\t';
}

static bool is_letter(char character)
{
    return character >= 'A' && character <= 'Z';
}

char words_at(uint8_t place)
{
    return place < WORDS_SIZE ? text[place] : '\0';
}

void words_put(uint8_t place, char character)
{
    if (place < WORDS_SIZE) {
        text[place] = character;
    }
}

/* Converts to upper case and removes both kinds of comment, in place. */
static void tidy(uint8_t first)
{
    uint8_t to = first;
    bool inside = false; /* true: inside a comment in parentheses */

    for (uint8_t from = first; words_at(from) != '\0' && (inside || words_at(from) != ';'); from++) {
        const char next = words_at(from);
        if (inside) {
            inside = next != ')';
        } else if (next == '(') {
            inside = true;
        } else {
            const bool small = next >= 'a' && next <= 'z';
            words_put(to, small ? (char)(next - 'a' + 'A') : next);
            to++;
        }
    }
    words_put(to, '\0');
}

uint8_t words_skip_blanks(uint8_t place)
{
    while (is_blank(words_at(place))) {
        place++;
    }
    return place;
}

bool words_take(uint8_t first)
{
    tidy(first);
    uint8_t rest = words_skip_blanks(first);

    words_letter = words_at(rest);
    words_command = WORDS_NO_COMMAND;
    if (words_letter == '\0') {
        return false;
    }
    if (!is_letter(words_letter)) {
        return true;
    }
    rest = words_skip_blanks((uint8_t)(rest + 1u));
    char next = words_at(rest);
    if (is_digit(next)) {
        words_command = 0;
    }
    for (; is_digit(next); next = words_at(++rest)) {
        if (words_command <= MOST_BEFORE_DIGIT) {
            words_command = (uint16_t)(10u * words_command + (uint16_t)(next - '0'));
        } else {
            words_command = WORDS_NO_COMMAND;
        }
    }
    if (next == '.') {
        words_command = WORDS_NO_COMMAND; /* fractions, such as M105.5, are not supported */
    }
    parameters = rest;
    return true;
}

/* Reads the number at this place. */
static uint8_t read_number(uint8_t place, float *number)
{
    uint32_t digits = 0;
    uint8_t decimals = 0; /* decimals used */
    bool any = false;
    bool behind_point = false;
    char next = words_at(place);
    const bool negative = next == '-';

    if (negative || next == '+') {
        next = words_at(++place);
    }
    for (; is_digit(next) || (next == '.' && !behind_point); next = words_at(++place)) {
        if (next == '.') {
            behind_point = true;
            continue;
        }
        any = true;
        if (behind_point) {
            if (decimals >= MOST_DECIMALS || digits > UINT32_MAX / 20u) {
                continue;
            }
            decimals++;
        }
        digits = 10u * digits + (uint32_t)(next - '0');
        if (!behind_point && digits > MOST_WHOLE) {
            return WORD_BAD;
        }
    }
    if (words_letter == 'M' && next == 'E') {
        return WORD_BAD; /* 1E-5 must not be read as 1; but in G0 and G1, E is an axis */
    }
    next = words_at(words_skip_blanks(place));
    if (!any || (next != '\0' && !is_letter(next))) {
        return WORD_BAD;
    }
    /* Seven digits are exact in a float: only this division rounds, to the nearest float. */
    *number = (float)digits / pgm_read_float(&TENS[decimals]);
    if (negative) {
        *number = -*number;
    }
    return WORD_NUMBER;
}

uint8_t words_find(char letter, float *number)
{
    uint8_t place = parameters;
    char next = words_at(place);

    while (next != letter) {
        if (next == '\0') {
            return WORD_NONE;
        }
        next = words_at(++place);
    }
    place++;
    const uint8_t behind = words_skip_blanks(place);
    next = words_at(behind);
    if (next == '\0' || (is_letter(next) && behind != place)) {
        return WORD_ALONE;
    }
    return read_number(behind, number);
}

bool words_count(char letter, uint8_t if_none, uint8_t *count)
{
    float number;

    switch (words_find(letter, &number)) {
    case WORD_NONE:
        *count = if_none;
        return true;
    case WORD_NUMBER:
        break;
    default:
        return false;
    }
    if (!(number >= 0.0f && number <= 255.0f)) {
        return false;
    }
    *count = (uint8_t)number;
    return (float)*count == number;
}
