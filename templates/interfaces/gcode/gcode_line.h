/* Assembles lines from the host, and checks their number and checksum. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t, int32_t */

enum {
    LINE_NONE,        /* nothing complete yet, or nothing to do */
    LINE_COMMAND,     /* a command, now in gcode_words */
    LINE_REPEATED,    /* executed before, and sent again: only answer it */
    LINE_TOO_LONG,    /* intact, but longer than any known command */
    LINE_UNREADABLE,  /* damaged, and the host does not number its lines */
    LINE_WRONG_FIRST, /* this and all below: the host must resend, beginning with line_last + 1 */
    LINE_DAMAGED = LINE_WRONG_FIRST,
    LINE_CHECKSUM,
    LINE_NO_CHECKSUM,
    LINE_NO_NUMBER,
    LINE_OUT_OF_ORDER
};

/* Number of the last line accepted. */
extern int32_t line_last;

void line_start(void);

/* Process the received bytes, at most up to the end of a line, and return the kind of line. After a
 * wrong line, all other bytes received so far are dropped: they follow a gap. */
uint8_t line_tick(void);

/* True from time to time while a host that numbers its lines is silent: if it has missed an "ok", or
 * this controller the end of a line, each would wait for the other for ever. */
bool line_asks_for_more(void);
