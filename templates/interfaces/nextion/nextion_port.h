/* The serial line to the touch display. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t, uint16_t */

/* Replaces a byte that was damaged, or for which there was no room: no command contains it. */
enum { NEXTION_PORT_DAMAGED = 0x15 };

/* Maximum length of an instruction. */
enum { NEXTION_PORT_SIZE = 75 };

/* Called in each tick: a flipped register bit lasts until the next one. Before another baud rate
 * is set, the port must have been free for a turn: only then has the last byte been sent. */
void nextion_port_set_registers(uint16_t divisor);

/* True while no received byte waits. */
bool nextion_port_is_silent(void);

/* The next byte received; false if there is none. */
bool nextion_port_take(uint8_t *byte);

/* True when all bytes have been handed to the transmitter. */
bool nextion_port_is_free(void);

/* Put a byte of the next instruction in its place; only while the port is free. */
void nextion_port_put(uint8_t place, char byte);

/* Send the bytes in the first `length` places; only while the port is free. */
void nextion_port_send(uint8_t length);
