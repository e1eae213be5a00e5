/* A monitor's warning on the display's second line. */
#ifndef MONITORS_SHOWN_H
#define MONITORS_SHOWN_H

#include <stdbool.h> /* bool */

/* Show the warning, by turns with the line's other text; false if it is the other text's turn. */
bool monitors_show(void);

#endif
