/* The serial port of the log: a few bytes each way, by interrupt. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t */

enum { LOG_PORT_SIZE = 32 };

/* Replaces a byte that was damaged on the line, or for which there was no room. */
enum { LOG_PORT_DAMAGED = 0 };

/* Called at the start and in each tick: a flipped register bit lasts until the next one. */
void log_port_set_registers(void);

/* True if a received byte waits. */
bool log_port_has_received(void);

/* The next byte received; false when there is none. */
bool log_port_take(char *byte);

/* True when all bytes have been handed to the transmitter. */
bool log_port_is_empty(void);

/* Send `size` bytes, at most LOG_PORT_SIZE; only while the port is empty. */
void log_port_send(const char *text, uint8_t size);
