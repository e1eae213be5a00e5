/* The entries of the log, in a ring: the oldest makes room for the newest. */
#ifndef LOG_RING_H
#define LOG_RING_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* int16_t, uint32_t */

enum { LOG_NO_READING = INT16_MIN };

struct log_entry {
    int16_t temperature_dc; /* 0.1 degC, or LOG_NO_READING */
    int16_t setpoint_dc;
};

/* Entries are numbered from 0, when the log began: the first that may be there, and the one behind
 * the newest. */
uint32_t log_ring_first(void);
uint32_t log_ring_end(void);

/* True if an entry can be read now, without waiting. */
bool log_ring_is_ready(void);

/* Read an entry from the first to the newest; false if it was cut short. */
bool log_ring_read(uint32_t number, struct log_entry *into);

/* Add an entry. */
void log_ring_note(const struct log_entry *entry);

/* Forget all entries, and begin with number 0 again. */
void log_ring_clear(void);

#endif
