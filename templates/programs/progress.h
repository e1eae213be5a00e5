/* How far the program is, kept in EEPROM: what is needed to go on after a loss of power. */
#ifndef PROGRESS_H
#define PROGRESS_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t, uint16_t, uint32_t */

/* Of the program that runs (program.h); kind, target and length follow from the stored program. */
struct progress_record {
    uint8_t state;
    uint8_t number;
    uint8_t segment;
    uint8_t ended;
    uint16_t program_crc; /* programs_crc of what was started */
    float first_c;
    float from_c;
    float setpoint_c;
    float temperature_c;
    uint32_t elapsed;
    uint32_t clock;
    uint32_t segment_clock;
    uint32_t energy;
};

/* After a reset: find the newest record. */
void progress_start(void);

/* Copy what `progress_start` has found; false if there was none, and what was copied means nothing.
 * To be called before anything is saved. */
bool progress_found(struct progress_record *into);

/* Write a record soon, in the background: as things are when it is begun (program_note). A wish while
 * one is written is fulfilled behind it. */
void progress_save(void);

/* Saves since the EEPROM was erased, this firmware's alone. */
uint32_t progress_saves(void);

/* Once a tick, behind the control step: write one byte. */
void progress_tick(void);

#endif
