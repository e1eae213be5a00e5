/* The line of the Modbus slave: frames that end by silence, and the answers to them. */
#ifndef MODBUS_LINE_H
#define MODBUS_LINE_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t, uint16_t */

enum { MODBUS_FRAME_SIZE = 256 }; /* the longest that the standard knows, with its CRC */
enum { MODBUS_TO_ALL = 0 };       /* the address that means every slave */

/* A request as it came: address, function, data. Its answer is written over it. */
extern uint8_t modbus_frame[MODBUS_FRAME_SIZE];

/* Since reset; each wraps. The names are those of the standard's diagnostics. */
struct modbus_counters {
    uint16_t messages;   /* frames on the line with a good CRC, to whomever */
    uint16_t errors;     /* frames that were damaged */
    uint16_t exceptions; /* requests that were answered with an exception */
    uint16_t requests;   /* frames to this slave, or to all */
    uint16_t unanswered; /* of these those to all */
    uint16_t overruns;   /* frames of which a character was lost */
};

extern struct modbus_counters modbus_counters;

void modbus_line_start(void);

/* A request waits, with a good CRC, to this slave or to all. */
bool modbus_line_is_asked(void);

/* Its length, without its CRC. */
uint16_t modbus_line_length(void);

/* Send this much of `modbus_frame`, and a CRC; 0: nothing. Then listen again. */
void modbus_line_answer(uint8_t length);

#endif
