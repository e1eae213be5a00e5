/* The last faults since the reset, also one that the reset latched again; for a display. */

#include <stdint.h> /* uint8_t, uint32_t */

enum { FAULT_LOG_SIZE = 8 };

struct fault_log_entry {
    uint8_t code;        /* the rule that tripped */
    float temperature_c; /* temperature of the loop or monitor that tripped; 0 for other parts */
    uint32_t time_s;     /* time of the trip since the reset; 0 if the fault was latched before it */
};

/* The entry at `index`, 0 for the newest; null if there is none. */
const struct fault_log_entry *fault_log_at(uint8_t index);

/* Number of faults since the reset, wraps: it changes whenever the list changes. */
uint8_t fault_log_count(void);

/* Once per tick: add a new fault to the list. */
void fault_log_tick(void);
