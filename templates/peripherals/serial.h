/* Serial transmitter: an interrupt sends its buffer. It receives nothing. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t */

enum { SERIAL_SIZE = 16 };

/* Called in each tick: a flipped register bit lasts until the next one. */
void serial_set_registers(void);

/* True when all bytes have been handed to the transmitter. */
bool serial_is_empty(void);

/* Send `size` bytes, at most SERIAL_SIZE; only while the transmitter is empty. */
void serial_send(const char *text, uint8_t size);
