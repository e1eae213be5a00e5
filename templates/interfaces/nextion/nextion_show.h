/* The contents of the components of a touch display's page. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t */

/* Send all contents of the page again. */
void show_anew(void);

/* True if a component of the page must be checked: all are, after each control step, one per turn. */
bool show_is_due(uint8_t page);

/* Check the next component, and send its content if it has changed; false if it has not. */
bool show_say(void);
