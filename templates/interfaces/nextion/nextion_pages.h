/* Which page a touch display shows, and which it should. */
#ifndef NEXTION_PAGES_H
#define NEXTION_PAGES_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t */

extern uint8_t pages_shown;

/* The display has started: it shows its first page, and knows nothing. */
void pages_start(void);

/* The display says that it shows this page, whose components begin anew. */
void pages_note(uint8_t page);

/* It should show this page. */
void pages_want(uint8_t page);

/* In a turn: a fault has a page of its own, which goes when it is acknowledged. */
void pages_turn(void);

/* Once a second. */
void pages_beat(void);

/* Ask again for a page that has not been seen. */
void pages_retry(void);

/* A page was ordered and may be on its way: the one that goes takes nothing any more. */
bool pages_are_turning(void);

/* Say that another page is wanted; false if there is nothing to say. */
bool pages_say(void);

#endif
