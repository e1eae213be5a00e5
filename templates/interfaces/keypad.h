/* The five keys of the LCD keypad shield: a resistor ladder on one analog pin. */
#ifndef KEYPAD_H
#define KEYPAD_H

#include <stdint.h> /* uint8_t */

enum { KEY_NONE, KEY_RIGHT, KEY_UP, KEY_DOWN, KEY_LEFT, KEY_SELECT };

void keypad_start(void);

/* Once a tick: the key that has just gone down, else KEY_NONE. */
uint8_t keypad_tick(void);

#endif
