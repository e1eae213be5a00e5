/* G0, G1 and related commands: converts the feed's millimetres to motor steps. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t */

enum { FEED_DONE, FEED_WAITS, FEED_BAD_NUMBER, FEED_LIMITS, FEED_HEATER_OFF };

/* G0, G1: make the line's move; FEED_WAITS if it must wait for the moves before it. */
uint8_t feed_move(void);

/* G92: the present position becomes the line's number. False: it is invalid or too large. */
bool feed_rename_place(void);

/* M82, M83: a length is a position (`yes`), or a distance from the present position. */
void feed_use_places(bool yes);

/* M400, M18: wait for the end of all moves; then, if `disable`, switch the motor's current off. */
void feed_finish(bool disable);

/* Try again to make the waiting move; true while it still waits. */
bool feed_is_waiting(void);

void feed_forget_waiting(void);

/* M410: slow down, stop, and cancel the rest of the moves. */
void feed_rest(void);

/* Do the same as feed_rest(), but only if a loop that must be ready for the feed is off. */
void feed_rest_if_off(void);

float feed_position_mm(void);
