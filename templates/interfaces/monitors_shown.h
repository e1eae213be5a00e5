/* A monitor's warning on the display's second line. */
#ifndef MONITORS_SHOWN_H
#define MONITORS_SHOWN_H

#include <stdbool.h> /* bool */

/* Show it, by turns with what else is there; false where it is not its turn. */
bool monitors_show(void);

#endif
