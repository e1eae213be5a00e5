/* The program that a touch display shows, and the changes to it. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t, int32_t */

#include "programs.h" /* struct stored_program */

extern struct stored_program points_shown;
extern uint8_t points_number;   /* the place of the program */
extern uint8_t points_marked;   /* the segment that was touched last; 0: none */
extern uint8_t points_revision; /* changes after every change, wraps */

void points_start(void);

/* Show the program at a place. */
bool points_show(uint8_t number);

/* Change segments by the rest of the command: `n,minutes,temperature[,kind]:` and so on; all of
 * them, or none. */
bool points_change(void);

/* Change the program's name to the rest of the command. */
bool points_rename(void);

/* True while a change waits to be written. */
bool points_are_waiting(void);

/* Convert the time of a segment to hundredths of a minute. */
int32_t points_minutes(uint32_t seconds);

/* In each turn: start to store a change; then show the program that was requested meanwhile. */
void points_turn(void);
