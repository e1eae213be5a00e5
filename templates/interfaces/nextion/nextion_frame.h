/* What a touch display sends, put together: orders of ours, and answers of its own. */
#ifndef NEXTION_FRAME_H
#define NEXTION_FRAME_H

#include <stdint.h> /* uint8_t */

enum {
    FRAME_NOTHING = 0,
    FRAME_ORDER = 1,   /* it is in frame_text */
    FRAME_STARTED = 2, /* the display has, and knows nothing yet */
    FRAME_PAGE = 3,    /* it shows frame_page */
    FRAME_LOST = 4     /* it has lost some of what was sent */
};

/* What stood between `#` and `;`, a 0 behind it. */
extern char frame_text[];
extern uint8_t frame_page;

/* Take one byte; tells what it has completed. */
uint8_t frame_take(uint8_t byte);

#endif
