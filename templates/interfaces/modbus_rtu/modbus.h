/* The Modbus slave: executes the functions. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint16_t */

/* Result of a request: done, or the code of an exception. */
enum { MODBUS_DONE = 0, MODBUS_BAD_FUNCTION = 1, MODBUS_BAD_ADDRESS = 2, MODBUS_BAD_VALUE = 3 };

void modbus_start(void);

/* Answer the waiting request: call it between two ticks, if `modbus_line_is_asked`. */
void modbus_answer(void);

/* Once per tick: count how long the master is silent. */
void modbus_tick(void);

/* Ticks since the last request to this slave or to all, or since reset. Stays at its largest value. */
uint16_t modbus_silent_ticks(void);

/* True if there was a request to this slave or to all since the reset. */
bool modbus_was_heard(void);
