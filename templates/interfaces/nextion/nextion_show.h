/* What the components of a touch display's page show. */
#ifndef NEXTION_SHOW_H
#define NEXTION_SHOW_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t */

/* Everything on the page is to be said again. */
void show_anew(void);

/* Whether a component of a page is to be looked at: all are after every control step, one a turn. */
bool show_is_due(uint8_t page);

/* Look at the next one, and say what it shows if it has changed; false if not. */
bool show_say(void);

#endif
