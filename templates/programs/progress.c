/* Progress of the program in EEPROM: a ring of slots, so that all cells wear equally.
 *
 * Each save goes to the oldest slot; the newest valid slot is used. A slot begins and ends with the
 * lowest byte of its sequence number, and is written from its first byte to its last. If the write
 * is interrupted, these two bytes differ; in the first or last byte, the CRC is wrong or the slot
 * is complete. So after a loss of power at any byte, the old or the new record is used. A slot
 * written for another spec has a wrong CRC.
 */
#include "progress.h"

#include <avr/eeprom.h> /* eeprom_read_block, eeprom_write_byte, eeprom_is_ready */
#include <stddef.h>     /* offsetof */
#include <util/crc16.h> /* _crc16_update: x^16 + x^15 + x^2 + 1 */

#include "config.h"  /* PROGRESS_*, SPEC_DIGEST */
#include "program.h" /* program_note */

struct slot {
    uint32_t sequence; /* saves so far, this one included; its lowest byte comes first */
    struct progress_record record;
    uint16_t crc; /* CRC of the spec's digest and all members above */
    uint8_t last; /* lowest byte of the sequence */
};

_Static_assert(sizeof(struct slot) == PROGRESS_SLOT_BYTES, "the layout of the EEPROM says so");

static struct slot newest; /* also while it is being written; sequence 0: none */
static uint8_t place;                          /* index of that slot */
static uint8_t next_byte = sizeof(struct slot); /* index of the byte to write next; sizeof: none */
static bool save_wanted;

static uint8_t *address(uint8_t of_slot, uint8_t offset)
{
    return (uint8_t *)(PROGRESS_EEPROM + of_slot % PROGRESS_SLOTS * sizeof(struct slot) + offset);
}

static uint16_t crc_of(const struct slot *slot)
{
    const uint32_t digest = SPEC_DIGEST;
    const uint8_t *const bytes = (const uint8_t *)slot;
    uint16_t crc = 0xFFFF;

    for (uint8_t i = 0; i < sizeof digest; i++) {
        crc = _crc16_update(crc, ((const uint8_t *)&digest)[i]);
    }
    for (uint8_t i = 0; i < offsetof(struct slot, crc); i++) {
        crc = _crc16_update(crc, bytes[i]);
    }
    return crc;
}

static bool is_valid(const struct slot *slot)
{
    return slot->last == (uint8_t)slot->sequence && slot->crc == crc_of(slot);
}

void progress_start(void)
{
    struct slot candidate;

    for (uint8_t i = 0; i < PROGRESS_SLOTS; i++) {
        eeprom_read_block(&candidate, address(i, 0), sizeof candidate);
        if (candidate.sequence > newest.sequence && is_valid(&candidate)) {
            newest = candidate;
            place = i;
        }
    }
}

bool progress_found(struct progress_record *into)
{
    *into = newest.record;
    return newest.sequence != 0;
}

void progress_save(void)
{
    save_wanted = true;
}

uint32_t progress_saves(void)
{
    return newest.sequence;
}

static void begin(void)
{
    save_wanted = false;
    newest.sequence++;
    program_note(&newest.record);
    newest.crc = crc_of(&newest);
    newest.last = (uint8_t)newest.sequence;
    place = (uint8_t)((place + 1u) % PROGRESS_SLOTS);
    next_byte = 0;
}

void progress_tick(void)
{
    if (!eeprom_is_ready()) {
        return; /* settings are written first; the record is filled later, to be up to date */
    }
    if (next_byte < sizeof newest) {
        eeprom_write_byte(address(place, next_byte), ((const uint8_t *)&newest)[next_byte]);
        next_byte++;
    } else if (save_wanted) {
        begin();
    }
}
