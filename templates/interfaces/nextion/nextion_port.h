/* The serial line to the touch display. */
#ifndef NEXTION_PORT_H
#define NEXTION_PORT_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t, uint16_t */

/* Stands for a byte that was damaged, or lost for want of room: no order has it in it. */
enum { NEXTION_PORT_DAMAGED = 0x15 };

void nextion_port_start(void);

/* Set the line's speed; only a turn after it is free. */
void nextion_port_divide(uint16_t divisor);

/* True while no received byte waits. */
bool nextion_port_is_silent(void);

/* The next byte received; false if there is none. */
bool nextion_port_take(uint8_t *byte);

/* True when all that was given has been handed to the transmitter. */
bool nextion_port_is_free(void);

/* Send `size` bytes, which stay as they are until it is free again; only while it is. */
void nextion_port_send(const char *bytes, uint8_t size);

#endif
