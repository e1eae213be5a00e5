/* Lines from the host: put together, checked by number and checksum. */
#ifndef GCODE_LINE_H
#define GCODE_LINE_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t, int32_t */

enum {
    LINE_NONE,        /* nothing complete yet, or nothing to do */
    LINE_COMMAND,     /* gcode_words holds it */
    LINE_REPEATED,    /* done before, and sent again: only the answer is due */
    LINE_TOO_LONG,    /* intact, but longer than any command known here */
    LINE_UNREADABLE,  /* damaged, in a conversation without numbers */
    LINE_WRONG_FIRST, /* from here on: the host must send again from line_last + 1 on */
    LINE_DAMAGED = LINE_WRONG_FIRST,
    LINE_CHECKSUM,
    LINE_NO_CHECKSUM,
    LINE_NO_NUMBER,
    LINE_OUT_OF_ORDER
};

/* Number of the last line taken. */
extern int32_t line_last;

void line_start(void);

/* Take what was received since the last call, up to the end of a line at most, and say what it is.
 * After a wrong one everything else that was received is forgotten: it follows a gap. */
uint8_t line_tick(void);

/* True now and then while a host that numbers its lines says nothing: it may have missed an "ok",
 * or we the end of its line, and then each waits for the other. */
bool line_asks_for_more(void);

#endif
