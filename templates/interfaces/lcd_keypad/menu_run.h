/* The menu's screens of the program that runs, and those that start, pause and end it. */
#ifndef MENU_RUN_H
#define MENU_RUN_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t */

/* Temperature, setpoint and what the program does. */
void menu_show_state(void);

/* How long program and segment have run. */
void menu_show_times(void);

/* Start a program, or say what the one that runs shall do. */
void menu_run_show(void);

/* True if the screen had a use for the key. */
bool menu_run_key(uint8_t key);

/* End a hold that waits for the operator; false if there is none. */
bool menu_run_go_on(void);

#endif
