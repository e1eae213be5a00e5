/* Reads the words of one line of G-code: a letter and a number, such as S200. */
#include "gcode_words.h"

#include <avr/pgmspace.h> /* PROGMEM */

char words_letter;
uint16_t words_command;

static const char *parameters = "";

static const float TENS[] PROGMEM = { 1.0f, 10.0f, 100.0f, 1000.0f, 10000.0f, 100000.0f, 1000000.0f };

/* Further decimals are read, but ignored. */
enum { MOST_DECIMALS = sizeof TENS / sizeof TENS[0] - 1 };

/* With one more digit, a command number has four: the most allowed. */
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

/* Converts to upper case and removes both kinds of comment, in place. */
static void tidy(char *text)
{
    char *to = text;
    bool inside = false; /* true: inside a comment in parentheses */

    for (const char *from = text; *from != '\0' && (inside || *from != ';'); from++) {
        if (inside) {
            inside = *from != ')';
        } else if (*from == '(') {
            inside = true;
        } else {
            const bool small = *from >= 'a' && *from <= 'z';
            *to++ = small ? (char)(*from - 'a' + 'A') : *from;
        }
    }
    *to = '\0';
}

static const char *skip_blanks(const char *text)
{
    while (is_blank(*text)) {
        text++;
    }
    return text;
}

bool words_take(char *text)
{
    tidy(text);
    const char *rest = skip_blanks(text);

    words_letter = *rest;
    words_command = WORDS_NO_COMMAND;
    if (words_letter == '\0') {
        return false;
    }
    if (!is_letter(words_letter)) {
        return true;
    }
    rest = skip_blanks(rest + 1);
    if (is_digit(*rest)) {
        words_command = 0;
    }
    for (; is_digit(*rest); rest++) {
        if (words_command <= MOST_BEFORE_DIGIT) {
            words_command = (uint16_t)(10u * words_command + (uint16_t)(*rest - '0'));
        } else {
            words_command = WORDS_NO_COMMAND;
        }
    }
    if (*rest == '.') {
        words_command = WORDS_NO_COMMAND; /* a variant, such as M105.5: not supported */
    }
    parameters = rest;
    return true;
}

/* Reads the number at `text`. */
static uint8_t read_number(const char *text, float *number)
{
    uint32_t digits = 0;
    uint8_t whole = 0;    /* digits before the point, without leading zeros */
    uint8_t decimals = 0; /* decimals used */
    bool any = false;
    bool behind_point = false;
    const bool negative = *text == '-';

    if (*text == '-' || *text == '+') {
        text++;
    }
    for (; is_digit(*text) || (*text == '.' && !behind_point); text++) {
        if (*text == '.') {
            behind_point = true;
            continue;
        }
        any = true;
        if (behind_point && (decimals == MOST_DECIMALS || digits > UINT32_MAX / 20u)) {
            continue;
        }
        digits = 10u * digits + (uint32_t)(*text - '0');
        if (behind_point) {
            decimals++;
        } else if (digits != 0) {
            whole++;
            if (whole > WORDS_WHOLE_DIGITS) {
                return WORD_BAD;
            }
        }
    }
    if (words_letter == 'M' && *text == 'E') {
        return WORD_BAD; /* 1E-5 must not be read as 1; but in G0 and G1, E is an axis */
    }
    text = skip_blanks(text);
    if (!any || (*text != '\0' && !is_letter(*text))) {
        return WORD_BAD;
    }
    /* With up to seven digits there is only this one rounding, as in any other reader of decimals. */
    *number = (float)digits / pgm_read_float(&TENS[decimals]);
    if (negative) {
        *number = -*number;
    }
    return WORD_NUMBER;
}

uint8_t words_find(char letter, float *number)
{
    for (const char *text = parameters; *text != '\0'; text++) {
        if (*text != letter) {
            continue;
        }
        const char *behind = skip_blanks(text + 1);
        if (*behind == '\0' || (is_letter(*behind) && behind != text + 1)) {
            return WORD_ALONE;
        }
        return read_number(behind, number);
    }
    return WORD_NONE;
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
