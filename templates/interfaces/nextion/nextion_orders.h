/* What a finger on a touch display orders. */
#ifndef NEXTION_ORDERS_H
#define NEXTION_ORDERS_H

#include <stdbool.h> /* bool */

/* Do the order that stands in `text`; false: there is none such, it is malformed or cannot be done
 * now, and nothing has changed. */
bool orders_do(const char *text);

#endif
