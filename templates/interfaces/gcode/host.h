/* The serial line to a host: two rings, filled and emptied by interrupt. */
#ifndef HOST_H
#define HOST_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t */

/* Stands in the place of bytes that were damaged on the line, or for which there was no room. */
enum { HOST_DAMAGED = 0 };

/* What a line can ask for that must not wait for its turn: see host_take_urgent. */
enum { HOST_STOP = 1, HOST_GO_ON = 2, HOST_REST = 4 };

void host_start(void);

/* The next byte received; false when there is none. */
bool host_take(char *byte);

/* Forget what was received. True when that ended within a line. */
bool host_drop(void);

/* What was asked for since the last call, recognised the moment it came, however many lines wait
 * before it: M112 (HOST_STOP), M108 (HOST_GO_ON), M410 (HOST_REST). */
uint8_t host_take_urgent(void);

/* M112 has come, and what is taken next was sent before it: that must not undo the stop. */
bool host_stop_is_ahead(void);

/* Send one byte; false when there is no room now. */
bool host_put(char byte);

#endif
