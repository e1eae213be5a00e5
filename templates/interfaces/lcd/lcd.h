/* HD44780 text display, 16 x 2, 4-bit bus, written one cell a tick. */
#ifndef LCD_H
#define LCD_H

#include <stdint.h> /* uint8_t */

enum { LCD_COLUMNS = 16, LCD_CELLS = 32 };

void lcd_start(void);

/* Put `text` into `line` (0 or 1) from its first column, and blanks after it. */
void lcd_write(uint8_t line, const char *text);

/* Once a tick: send a few changed cells. */
void lcd_tick(void);

#endif
