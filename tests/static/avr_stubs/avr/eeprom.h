/* Stand-in for avr-libc: an EEPROM that holds anything, and is never read or written beyond its
 * end. */
#ifndef STATIC_EEPROM_H
#define STATIC_EEPROM_H

#include <avr/io.h> /* E2END */
#include <stddef.h> /* size_t */
#include <stdint.h> /* uint8_t */

#include "harness.h"

#define eeprom_is_ready() ((int)unknown_byte)

/*@ requires in_eeprom: (unsigned)place <= E2END;
    assigns \result \from unknown_byte; */
uint8_t eeprom_read_byte(const uint8_t *place);

/*@ requires in_eeprom: (unsigned)place <= E2END;
    assigns \nothing; */
void eeprom_write_byte(uint8_t *place, uint8_t value);

/*@ requires in_eeprom: (unsigned)from + size <= E2END + 1;
    requires room: \valid((char *)to + (0 .. size - 1));
    assigns ((char *)to)[0 .. size - 1] \from unknown_byte;
    ensures written: \initialized((char *)to + (0 .. size - 1)); */
void eeprom_read_block(void *to, const void *from, size_t size);

#endif
