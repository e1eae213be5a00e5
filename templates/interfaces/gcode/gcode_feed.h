/* G0, G1 and what belongs to them: the feed's length in millimetres as its steps. */
#ifndef GCODE_FEED_H
#define GCODE_FEED_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t */

enum { FEED_DONE, FEED_WAITS, FEED_BAD_NUMBER, FEED_LIMITS, FEED_HEATER_OFF };

/* G0, G1: move as the present line says; FEED_WAITS when the last move must end before. */
uint8_t feed_move(void);

/* G92: call the present place what the present line says. False when it is no number. */
bool feed_rename_place(void);

/* M82, M83: whether a length is a place, or a distance from where the feed is. */
void feed_use_places(bool yes);

/* M400, M18: wait for the end of all moves, and then perhaps let the motor go. */
void feed_finish(bool disable);

/* Try again what waits; true while it does. */
bool feed_is_waiting(void);

void feed_forget_waiting(void);

/* M410: slow down, stop, and forget the rest. */
void feed_rest(void);

/* The same when a loop is off that it waits for. */
void feed_rest_if_off(void);

float feed_position_mm(void);

#endif
