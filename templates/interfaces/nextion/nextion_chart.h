/* The charts of a touch display: the whole firing on one page, the last minutes on another. */
#ifndef NEXTION_CHART_H
#define NEXTION_CHART_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t */

/* Begin the chart of the firing anew. */
void chart_clear(void);

/* A page is shown, and its chart is empty. */
void chart_show(uint8_t page);

/* Once a second: note what is due. */
void chart_beat(void);

/* Say one thing about the chart of the page that is shown; false if there is nothing to say. */
bool chart_say(uint8_t page);

#endif
