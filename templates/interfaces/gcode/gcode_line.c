/* Assembles lines from the host, and checks their number and checksum.
 *
 * A numbered line is `N12 M105*36`: the number behind the star is the XOR of all bytes before it.
 */
#include "gcode_line.h"

#include "config.h"      /* HOST_SILENT_TICKS, HOST_MOST_REMINDERS */
#include "gcode_words.h" /* words_take */
#include "host.h"        /* host_take */

enum {
    BYTES_PER_TICK = 128, /* more than a line; takes 0.7 ms at 16 MHz */
    MOST_REPEATED = 32,   /* maximum number of lines that a host may have sent ahead */
    NO_STAR = UINT8_MAX
};

/* No number has more than seven digits: reports have room for no more. */
static const int32_t MOST_BEFORE_DIGIT = 1000000;
static const int32_t UNKNOWN = INT32_MAX;

int32_t line_last;

static uint8_t length;
static bool too_long;
static bool damaged;
static uint8_t sum;         /* XOR of all bytes so far */
static uint8_t star;        /* place of the last star, WORDS_SIZE if behind the longest line, or NO_STAR */
static uint8_t sum_at_star; /* XOR of the bytes before that star */
static int32_t claimed_sum; /* the checksum behind the star, as the host sent it; -1: none */
static bool behind_claim;

static bool skipping;  /* true: ignore bytes up to the next end of line */
static bool numbering; /* true: the host numbers its lines */
static bool anew;      /* true: after a damaged M110, accept any next number */
static uint8_t repeats_left;
static uint16_t silent_ticks;
static uint8_t reminders;

static bool is_digit(char character)
{
    return character >= '0' && character <= '9';
}

static int32_t with_digit(int32_t number, char digit)
{
    return number < MOST_BEFORE_DIGIT ? 10 * number + (uint8_t)(digit - '0') : number;
}

void line_start(void)
{
    length = 0;
    too_long = false;
    damaged = false;
    sum = 0;
    star = NO_STAR;
}

/* Updates the checksum with each byte, so that it is known for a line of any length. */
static void follow_sum(char byte)
{
    if (byte == '*') {
        star = length;
        sum_at_star = sum;
        claimed_sum = -1;
        behind_claim = false;
    } else if (is_digit(byte) && !behind_claim) {
        claimed_sum = with_digit(claimed_sum < 0 ? 0 : claimed_sum, byte);
    } else {
        behind_claim = true;
    }
    sum ^= (uint8_t)byte;
}

static void take_byte(char byte)
{
    if (((uint8_t)byte < ' ' && byte != '\t') || byte == '\x7F') {
        damaged = true;
        return;
    }
    follow_sum(byte);
    if (length >= WORDS_SIZE) {
        too_long = true;
        return;
    }
    words_put(length, byte);
    length++;
}

/* Assembles received bytes; true at the end of a line that is not empty. */
static bool assemble(void)
{
    char byte = '\0';

    for (uint8_t i = 0; i < BYTES_PER_TICK && host_take(&byte); i++) {
        silent_ticks = 0;
        reminders = 0;
        if (byte != '\n' && byte != '\r') {
            if (!skipping) {
                take_byte(byte);
            }
        } else if (skipping) {
            skipping = false;
        } else if (length != 0 || damaged) {
            words_put(length, '\0');
            return true;
        }
    }
    return false;
}

/* Reads the integer at `*place`, and moves `*place` behind it. */
static int32_t take_number(uint8_t *place)
{
    const bool negative = words_at(*place) == '-';
    int32_t number = 0;

    if (negative) {
        (*place)++;
    }
    for (; is_digit(words_at(*place)); (*place)++) {
        number = with_digit(number, words_at(*place));
    }
    return negative ? -number : number;
}

/* M110 sets the line number: to its parameter N, or to the number of its own line. */
static bool is_renumbering(int32_t number)
{
    float wanted;

    if (words_letter != 'M' || words_command != 110) {
        return false;
    }
    line_last = words_find('N', &wanted) == WORD_NUMBER ? (int32_t)wanted : number;
    repeats_left = 0;
    return true;
}

static uint8_t judge_number(int32_t number)
{
    const bool is_first = !numbering || anew;

    numbering = true;
    anew = false;
    if (is_renumbering(number)) {
        return LINE_COMMAND;
    }
    if (number == line_last + 1 || is_first) {
        line_last = number;
        if (repeats_left != 0) {
            repeats_left--;
        }
        return too_long ? LINE_TOO_LONG : LINE_COMMAND;
    }
    if (repeats_left != 0 && number <= line_last && number > line_last - MOST_REPEATED) {
        return LINE_REPEATED; /* sent twice: the host had not yet received our answer */
    }
    return LINE_OUT_OF_ORDER;
}

static uint8_t judge_numbered(uint8_t behind_n)
{
    if (star == NO_STAR) {
        return LINE_NO_CHECKSUM;
    }
    if (claimed_sum != sum_at_star) {
        return LINE_CHECKSUM;
    }
    const int32_t number = take_number(&behind_n);
    (void)words_take(behind_n);
    return judge_number(number);
}

static uint8_t judge_plain(uint8_t start)
{
    if (star != NO_STAR) {
        return LINE_NO_NUMBER;
    }
    if (too_long) {
        return LINE_TOO_LONG;
    }
    if (!words_take(start)) {
        return LINE_NONE;
    }
    (void)is_renumbering(line_last);
    return LINE_COMMAND;
}

static uint8_t judge(void)
{
    words_put(star, '\0');
    if (damaged) {
        return numbering ? LINE_DAMAGED : LINE_UNREADABLE;
    }
    const uint8_t start = words_skip_blanks(0);
    const char first = words_at(start);
    return first == 'N' || first == 'n' ? judge_numbered((uint8_t)(start + 1u)) : judge_plain(start);
}

/* True if the word at `from` is not the first of the line, but its last, and has the wanted number. */
static bool ends_with(uint8_t from, uint8_t behind, int32_t number, int32_t wanted)
{
    return words_at((uint8_t)(from - 1u)) == ' ' && words_at(behind) == '\0' && number == wanted;
}

static bool is_m110(uint8_t from)
{
    static const char COMMAND[] = { 'M', '1', '1', '0' };

    for (uint8_t i = 0; i < sizeof COMMAND; i++) {
        if (words_at((uint8_t)(from + i)) != COMMAND[i]) {
            return false;
        }
    }
    return true;
}

/* A damaged line may have been M110 if it contains M110, if it ends with its own number, as in
 * OctoPrint's `N0 M110 N0`, or if its number is -1, as Printrun's. After M110 the host restarts its
 * numbers and cannot repeat older lines: a request for one makes OctoPrint end the print. So set the
 * number now, and accept any next one. Hosts restart at 0: of two numbers use the smaller one. */
static void save_renumbering(void)
{
    int32_t own = UNKNOWN;
    int32_t last = UNKNOWN;
    bool is_found = false;

    for (uint8_t from = 0; words_at(from) != '\0'; from++) {
        if (words_at(from) == 'N') {
            uint8_t behind = (uint8_t)(from + 1u);
            last = take_number(&behind);
            own = from == 0 ? last : own;
            is_found |= from == 0 ? own == -1 : ends_with(from, behind, last, own);
        }
        is_found |= is_m110(from);
    }
    const int32_t number = own < last ? own : last;
    if (!is_found || number == line_last + 1) {
        return; /* the host will send it again, like any other line */
    }
    if (number != UNKNOWN) {
        line_last = number;
    }
    repeats_left = 0;
    anew = true;
}

uint8_t line_tick(void)
{
    if (!assemble()) {
        return LINE_NONE;
    }
    const uint8_t kind = judge();
    line_start();
    if (kind >= LINE_WRONG_FIRST) {
        skipping = host_drop();
        repeats_left = MOST_REPEATED;
        if (kind != LINE_OUT_OF_ORDER) {
            save_renumbering();
        }
    }
    return kind;
}

bool line_asks_for_more(void)
{
    if (!numbering || reminders == HOST_MOST_REMINDERS) {
        return false;
    }
    silent_ticks++;
    if (silent_ticks < HOST_SILENT_TICKS) {
        return false;
    }
    silent_ticks = 0;
    reminders++;
    repeats_left = MOST_REPEATED;
    return true;
}
