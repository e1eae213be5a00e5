/* Commands from the pages of a touch display. */

#include <stdbool.h> /* bool */

/* Execute the command that was received; false: it is unknown, malformed or refused now, and nothing
 * has changed. */
bool orders_do(void);
