/* The words of one line of G-code: a letter and a number, such as S200. */
#ifndef GCODE_WORDS_H
#define GCODE_WORDS_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint16_t */

/* Of a command: no such number. */
enum { WORDS_NO_COMMAND = UINT16_MAX };

/* How far the whole part of a number may go: more digits are refused. */
enum { WORDS_WHOLE_DIGITS = 7 };

enum { WORD_NONE, WORD_ALONE, WORD_NUMBER, WORD_BAD };

/* The line's command, such as 'M' and 104. */
extern char words_letter;
extern uint16_t words_command;

/* Take a line's text from its command on, as upper case and without comments; it must stay.
 * False when there is no command: nothing, or a comment. */
bool words_take(char *text);

/* Look for parameter `letter`: WORD_NONE; WORD_ALONE, without a number behind it; WORD_NUMBER, and
 * the number; or WORD_BAD, something that is no number. */
uint8_t words_find(char letter, float *number);

/* The number of `letter` as 0..255, or `if_none`; false when it is there, and is no such number. */
bool words_count(char letter, uint8_t if_none, uint8_t *count);

#endif
