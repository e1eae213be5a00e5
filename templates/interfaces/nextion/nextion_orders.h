/* Commands from the pages of a touch display. */

#include <stdbool.h> /* bool */

/* Execute the received command. False: it is unknown, malformed or not allowed now; nothing has
 * changed. */
bool orders_do(void);
