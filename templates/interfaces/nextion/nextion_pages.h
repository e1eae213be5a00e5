/* The page that a touch display shows, and the page that it should show. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t */

extern uint8_t pages_shown;

/* The display has started: it shows its first page, without any data. */
void pages_start(void);

/* The display reports that it shows this page: its components have their initial values. */
void pages_note(uint8_t page);

/* Instruct the display to show this page. */
void pages_want(uint8_t page);

/* In each turn: show the page of a new fault, and leave it when the fault is acknowledged. */
void pages_turn(void);

/* Once per second: count the time between two instructions for a page. */
void pages_beat(void);

/* Repeat the instruction for an unconfirmed page. */
void pages_retry(void);

/* True while a page is not confirmed: nothing may be sent for the old page. */
bool pages_are_turning(void);

/* Send the instruction for a page; false if none is due. */
bool pages_say(void);
