/* The menu's screens of single values: setpoint and switch, gains, limits. */
#ifndef MENU_VALUES_H
#define MENU_VALUES_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t */

void menu_values_show(void);

/* True if the screen has used the key. */
bool menu_values_key(uint8_t key);

#endif
