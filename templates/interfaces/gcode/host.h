/* The serial line to a host: two rings, filled and emptied by interrupt. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t */

/* Replaces a byte that was damaged on the line, or for which there was no room. */
enum { HOST_DAMAGED = 0 };

/* Bits of host_take_urgent: commands that must not wait for their turn. */
enum { HOST_STOP = 1, HOST_GO_ON = 2, HOST_REST = 4 };

/* Called at the start and in each tick: a flipped register bit lasts until the next one. */
void host_set_registers(void);

/* The next byte received; false when there is none. */
bool host_take(char *byte);

/* Drop all received bytes. True if the last one was not the end of a line. */
bool host_drop(void);

/* The urgent commands since the last call: M112 (HOST_STOP), M108 (HOST_GO_ON), M410 (HOST_REST).
 * They are recognised when received, however many lines wait before them. */
uint8_t host_take_urgent(void);

/* True while the next byte to take was sent before an M112: it must not undo the stop. */
bool host_stop_is_ahead(void);

/* Number of bytes that can be sent now. */
uint8_t host_room(void);

/* Send one byte; false when there is no room now. */
bool host_put(char byte);
