/* A monitor's warning on the display's second line. */

#include <stdbool.h> /* bool */

/* Show the warning, by turns with the line's other text; false: there is none, or not its turn. */
bool monitors_show(void);
