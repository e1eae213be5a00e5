/* The Modbus slave: what each function does. */
#ifndef MODBUS_H
#define MODBUS_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint16_t */

/* How a request ends: exceptions by their codes. */
enum { MODBUS_DONE = 0, MODBUS_BAD_FUNCTION = 1, MODBUS_BAD_ADDRESS = 2, MODBUS_BAD_VALUE = 3 };

void modbus_start(void);

/* Answer the request that waits: between two ticks, when `modbus_line_is_asked`. */
void modbus_answer(void);

/* Once a tick: count how long the master is silent. */
void modbus_tick(void);

/* Ticks since the last request to this slave, or to all; or since reset. Stays at its largest. */
uint16_t modbus_silent_ticks(void);

/* There was one since the reset. */
bool modbus_was_heard(void);

#endif
