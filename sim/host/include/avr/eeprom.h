/* Stand-in for avr-libc: an EEPROM that checks its bounds and can lose its power (world.c). */
#ifndef HOST_EEPROM_H
#define HOST_EEPROM_H

#include <stdbool.h> /* bool */
#include <stddef.h>  /* size_t */
#include <stdint.h>  /* uint8_t */

bool eeprom_is_ready(void);
uint8_t eeprom_read_byte(const uint8_t *place);
void eeprom_read_block(void *to, const void *from, size_t size);
void eeprom_write_byte(uint8_t *place, uint8_t value);

#endif
