/* Reads the words of one line of G-code: a letter and a number, such as S200. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint16_t */

/* words_command if the line's command has no valid number. */
enum { WORDS_NO_COMMAND = UINT16_MAX };

/* Maximum number of digits before the point of a number: more are refused. */
enum { WORDS_WHOLE_DIGITS = 7 };

enum { WORD_NONE, WORD_ALONE, WORD_NUMBER, WORD_BAD };

/* The line's command: letter and number, such as 'M' and 104. */
extern char words_letter;
extern uint16_t words_command;

/* Take the text of a line, from its command on; the text is changed in place, and must stay.
 * False if there is no command: an empty line, or a comment. */
bool words_take(char *text);

/* Find parameter `letter`. Returns WORD_NONE; WORD_ALONE: without a number; WORD_NUMBER: with
 * `number` set; WORD_BAD: with something that is no number. */
uint8_t words_find(char letter, float *number);

/* Set `count` to the number of `letter`, or to `if_none`; false: it is no integer of 0 to 255. */
bool words_count(char letter, uint8_t if_none, uint8_t *count);
