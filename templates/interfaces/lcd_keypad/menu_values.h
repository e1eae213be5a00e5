/* The menu's screens of single values: setpoint and switch, gains, limits. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t */

void menu_values_show(void);

/* True if the screen has used the key. */
bool menu_values_key(uint8_t key);
