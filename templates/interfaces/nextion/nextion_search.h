/* A touch display at another speed is brought to that of this line. */
#ifndef NEXTION_SEARCH_H
#define NEXTION_SEARCH_H

#include <stdbool.h> /* bool */

/* Nobody answers: order the display to this line's speed, at each of its speeds. */
void search_begin(void);

/* True while the line has another speed, or noise on it. */
bool search_is_on(void);

/* A turn of it; true while it has the line. In its last turn it ends what it has left half said. */
bool search_turn(void);

#endif
