/* The program's progress in EEPROM: all that is needed to continue after a loss of power. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t, uint16_t, uint32_t */

/* Members of program.h's state; kind, target and length follow from the stored program. */
struct progress_record {
    uint8_t state;
    uint8_t number;
    uint8_t segment;
    uint8_t ended;
    uint16_t program_crc; /* programs_crc of the program that was started */
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

/* Copy the record that `progress_start` found. False: there was none, and the copy is not valid.
 * Call it before anything is saved. */
bool progress_found(struct progress_record *into);

/* Write a record soon, in the background, with the state at the time when writing begins
 * (program_note). A call during a write causes one more write after it. */
void progress_save(void);

/* Saves by this firmware since the EEPROM was erased. */
uint32_t progress_saves(void);

/* Once per tick, after the control step: write one byte. */
void progress_tick(void);
