/* HD44780 text display, 16 x 2, 4-bit bus, written a few cells per tick. */

#include <stdint.h> /* uint8_t */

enum { LCD_COLUMNS = 16, LCD_CELLS = 32 };

void lcd_start(void);

/* Write `text` into `line` (0 or 1) from the first column, followed by blanks. */
void lcd_write(uint8_t line, const char *text);

/* Once per tick: send a few cells, or instructions of the start-up sequence. */
void lcd_tick(void);
