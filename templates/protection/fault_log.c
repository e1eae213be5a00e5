/* The last faults since the reset, for a display: a ring in RAM. */
#include "fault_log.h"

#include <stddef.h> /* NULL */

#include "clock.h" /* clock_seconds */
#include "fault.h" /* fault */

static struct fault_log_entry entries[FAULT_LOG_SIZE];
static uint8_t newest;
static uint8_t size;
static uint8_t count;
static uint8_t seen_code; /* fault.code in the last tick */
static uint8_t seen_acknowledgements;

static void note(void)
{
    newest = (uint8_t)((newest + 1u) % FAULT_LOG_SIZE);
    entries[newest].code = fault.code;
    entries[newest].temperature_c = fault.temperature_c;
    entries[newest].time_s = clock_seconds();
    if (size < FAULT_LOG_SIZE) {
        size++;
    }
    count++;
}

void fault_log_tick(void)
{
    /* The same code, after an acknowledgement in between, is a new fault. */
    if (fault.code == seen_code && fault.acknowledgements == seen_acknowledgements) {
        return;
    }
    seen_code = fault.code;
    seen_acknowledgements = fault.acknowledgements;
    if (fault.code != FAULT_NONE) {
        note();
    }
}

const struct fault_log_entry *fault_log_at(uint8_t index)
{
    if (index >= size) {
        return NULL;
    }
    return &entries[(uint8_t)(newest + FAULT_LOG_SIZE - index) % FAULT_LOG_SIZE];
}

uint8_t fault_log_count(void)
{
    return count;
}
