/* The program that a touch display shows, and what is changed in it. */
#ifndef NEXTION_POINTS_H
#define NEXTION_POINTS_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t, int32_t */

#include "programs.h" /* struct stored_program */

extern struct stored_program points_shown;
extern uint8_t points_number;   /* its place */
extern uint8_t points_marked;   /* the segment that was touched last; 0: none */
extern uint8_t points_revision; /* another one after every change, wraps */

void points_start(void);

/* Show the program at a place. */
bool points_show(uint8_t number);

/* Change segments: `n,minutes,temperature[,kind]:` and so on. All of it, or nothing. */
bool points_change(const char *text);

/* Call it so. */
bool points_rename(const char *text);

/* A change has not begun to be written yet. */
bool points_are_waiting(void);

/* Time of a segment in hundredths of a minute. */
int32_t points_minutes(uint32_t seconds);

/* In every turn: have a change written, then show what was asked for meanwhile. */
void points_turn(void);

#endif
