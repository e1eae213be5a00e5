/* Assembles the bytes from a touch display to commands and answers.
 *
 * A command is `#`, printable characters, `;`. With any other byte, or too many, it is dropped; the
 * next `#` begins a new one. The display's own answers end with three bytes of 0xFF.
 */
#include "nextion_frame.h"

#include <string.h> /* memmove */

#include "config.h" /* NEXTION_ORDER_SIZE */

enum {
    ANSWER_SIZE = 6, /* the longest answer in use, with its end */
    ANSWER_PAGE = 0x66,
    ANSWER_LOST = 0x24,
    END = 0xFF
};

uint8_t frame_page;

/* The command's text. No pointer to it is stored, so a flipped bit cannot lead outside. */
static char text[NEXTION_ORDER_SIZE];
static uint16_t length;
static uint16_t next_place; /* index of the character that is read next */
static bool inside;
static uint8_t answer[ANSWER_SIZE] = { 1, 1, 1, 1, 1, 1 }; /* the last bytes; initially no answer */

/* Called after each byte of 0xFF: after the third in a row, evaluates the bytes before them. */
static uint8_t judge_answer(void)
{
    const uint8_t *const end = answer + ANSWER_SIZE - 3;

    if (end[0] != END || end[1] != END) {
        return FRAME_NOTHING;
    }
    if (answer[0] == 0 && answer[1] == 0 && answer[2] == 0) {
        return FRAME_STARTED;
    }
    if (answer[1] == ANSWER_PAGE) {
        frame_page = answer[2];
        return FRAME_PAGE;
    }
    return answer[2] == ANSWER_LOST ? FRAME_LOST : FRAME_NOTHING;
}

static uint8_t take_order(uint8_t byte)
{
    if (byte == '#') {
        inside = true;
        length = 0;
        return FRAME_NOTHING;
    }
    if (!inside) {
        return FRAME_NOTHING;
    }
    if (byte == ';' && length <= NEXTION_ORDER_SIZE) {
        inside = false;
        next_place = 0;
        return FRAME_ORDER;
    }
    if (byte < ' ' || byte > '~' || length >= NEXTION_ORDER_SIZE) {
        inside = false;
        return FRAME_NOTHING;
    }
    text[length] = (char)byte;
    length++;
    return FRAME_NOTHING;
}

uint8_t frame_take(uint8_t byte)
{
    memmove(answer, answer + 1, ANSWER_SIZE - 1);
    answer[ANSWER_SIZE - 1] = byte;
    const uint8_t order = take_order(byte);
    return byte == END ? judge_answer() : order;
}

char frame_peek(void)
{
    return next_place < length && next_place < NEXTION_ORDER_SIZE ? text[next_place] : '\0';
}

void frame_skip(void)
{
    next_place++;
}

bool frame_skip_if(char character)
{
    if (frame_peek() != character) {
        return false;
    }
    frame_skip();
    return true;
}
