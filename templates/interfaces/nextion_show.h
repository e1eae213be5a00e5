/* What the components of a touch display's page show. */
#ifndef NEXTION_SHOW_H
#define NEXTION_SHOW_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t */

/* Everything on the page is to be said again. */
void show_anew(void);

/* Look at the next component of a page, and say what it shows if it has changed; false if not. */
bool show_say(uint8_t page);

#endif
