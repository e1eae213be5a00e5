/* Finds entries of the register map, and makes the words and bits that a master reads. */

#include "modbus_map.h" /* struct map_entry */

enum { MAP_NOT_THERE = 0xFF };

/* Return the index of the entry with this address; or MAP_NOT_THERE if any of the `count` (at least
 * 1) addresses from there on does not exist. */
uint8_t map_find(const struct map_entry *table, uint8_t size, uint16_t address, uint16_t count);

uint16_t map_word(const struct map_entry *entry);
bool map_bit(const struct map_entry *entry);

/* Convert a float to steps of 1 / `per_unit`, rounded to nearest and limited to -32767..32767. */
int16_t map_scaled(float value, float per_unit);
