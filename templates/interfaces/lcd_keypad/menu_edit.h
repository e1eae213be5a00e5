/* The menu's screens that change a stored program. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t */

void menu_edit_show(void);

/* True if the screen has used the key. */
bool menu_edit_key(uint8_t key);
