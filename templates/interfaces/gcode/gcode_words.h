/* Reads the words of one line of G-code: a letter and a number, such as S200. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint16_t */

/* words_command if the line's command has no valid number. */
enum { WORDS_NO_COMMAND = UINT16_MAX };

/* Maximum length of a line, as in Marlin. */
enum { WORDS_SIZE = 96 };

enum { WORD_NONE, WORD_ALONE, WORD_NUMBER, WORD_BAD };

/* The line's command: letter and number, such as 'M' and 104. */
extern char words_letter;
extern uint16_t words_command;

/* The character at a place of the line; '\0' behind its end. */
char words_at(uint8_t place);

/* Put a character at a place of the line; a place beyond the longest line is ignored. */
void words_put(uint8_t place, char character);

/* The next place, from this one on, that is no space or tab. */
uint8_t words_skip_blanks(uint8_t place);

/* Read the line from this place on, where its command begins; the result is valid until the next
 * words_put(). False: there is no command, but an empty line or a comment. */
bool words_take(uint8_t first);

/* Find parameter `letter`. Returns WORD_NONE; WORD_ALONE: without a number; WORD_NUMBER: with
 * `number` set; WORD_BAD: with something that is no number. */
uint8_t words_find(char letter, float *number);

/* Set `count` to the number of `letter`, or to `if_none`. False: not an integer from 0 to 255. */
bool words_count(char letter, uint8_t if_none, uint8_t *count);
