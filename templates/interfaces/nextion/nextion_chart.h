/* The charts of a touch display: the whole firing on one page, the last minutes on another. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t */

/* Clear and restart the chart of the firing. */
void chart_clear(void);

/* The display shows this page now: its chart is empty. */
void chart_show(uint8_t page);

/* Once per second: add columns that are due. */
void chart_beat(void);

/* Send one instruction for the chart of the page shown; false if none is due. */
bool chart_say(uint8_t page);
