/* The menu's screens that show, start, pause and end a program. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t */

/* Show temperature, setpoint and the program's state. */
void menu_show_state(void);

/* Show how long program and segment have run. */
void menu_show_times(void);

/* Show the screen that starts a program, or gives commands to the running one. */
void menu_run_show(void);

/* True if the screen has used the key. */
bool menu_run_key(uint8_t key);

/* End a hold that waits for the operator; false if there is none. */
bool menu_run_go_on(void);
