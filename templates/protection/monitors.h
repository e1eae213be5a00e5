/* The monitors for those who tell people of them, numbered from 1. */
#ifndef MONITORS_H
#define MONITORS_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t */

/* The first one that warns; 0: none does. */
uint8_t monitors_warning(void);

/* How many there are. */
uint8_t monitors_count(void);

/* In flash. */
const char *monitors_name(uint8_t number);

bool monitors_warns(uint8_t number);

/* False if its last reading was not good. */
bool monitors_is_heard(uint8_t number);

/* Its last good reading. */
float monitors_celsius(uint8_t number);

#endif
