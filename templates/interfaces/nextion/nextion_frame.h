/* Assembles the bytes from a touch display to commands of its pages, and its own answers. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t */

enum {
    FRAME_NOTHING = 0,
    FRAME_ORDER = 1,   /* a command: frame_peek() reads it */
    FRAME_STARTED = 2, /* the display has started: send everything */
    FRAME_PAGE = 3,    /* the display shows page frame_page */
    FRAME_LOST = 4     /* the display has lost bytes */
};

extern uint8_t frame_page;

/* Process one byte; returns the FRAME_* that it has completed. */
uint8_t frame_take(uint8_t byte);

/* The next character of the command's text, which is between `#` and `;`; '\0' at its end. */
char frame_peek(void);

/* Skip the character that frame_peek() returns. */
void frame_skip(void);

/* Skip the next character if it is this one; true if it was skipped. */
bool frame_skip_if(char character);
