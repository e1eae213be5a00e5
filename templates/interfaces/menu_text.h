/* What the menu's screens share: their texts. */
#ifndef MENU_TEXT_H
#define MENU_TEXT_H

#include <stdint.h> /* uint8_t, uint32_t */

#include "lcd.h" /* LCD_COLUMNS */
#include "text.h" /* TEXT_SIZE */

enum { MENU_LINE_SIZE = LCD_COLUMNS + TEXT_SIZE };

/* Append to `text`, which has MENU_LINE_SIZE bytes and not more than LCD_COLUMNS characters yet. */
void menu_append_number(char *text, float value, uint8_t decimals);
void menu_append_celsius(char *text, float celsius);

/* Control steps as days, hours and minutes: "1d02h05m". */
void menu_append_time(char *text, uint32_t steps);

/* The rule of a fault, on one line of the display. */
void menu_show_fault(uint8_t line, uint8_t code);

#endif
