/* The line of the Modbus slave: receives frames, which end with a silence, and sends answers. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t, uint16_t */

enum { MODBUS_FRAME_SIZE = 256 }; /* the longest frame of the standard, with its CRC */
enum { MODBUS_TO_ALL = 0 };       /* the broadcast address */

/* A request as received: address, function, data. The answer overwrites it. */
extern uint8_t modbus_frame[MODBUS_FRAME_SIZE];

/* Counts since reset; each wraps. The names are those of the standard's diagnostics. */
struct modbus_counters {
    uint16_t messages;   /* frames with a good CRC, to any address */
    uint16_t errors;     /* damaged frames */
    uint16_t exceptions; /* requests answered with an exception */
    uint16_t requests;   /* frames to this slave or to all */
    uint16_t unanswered; /* requests to all, which get no answer */
    uint16_t overruns;   /* frames with a lost character */
};

extern struct modbus_counters modbus_counters;

void modbus_line_start(void);

/* Called in each tick: a flipped bit of a register or of the driver lasts until the next one. */
void modbus_line_set_registers(void);

/* True if a request to this slave or to all, with a good CRC, waits. */
bool modbus_line_is_asked(void);

/* Length of the request without its CRC. */
uint16_t modbus_line_length(void);

/* Send `length` bytes of `modbus_frame` and a CRC, or nothing if 0; then receive again. */
void modbus_line_answer(uint8_t length);
