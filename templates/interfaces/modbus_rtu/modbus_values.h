/* Find an entry of the register map, and make the words and bits that a master reads. */
#ifndef MODBUS_VALUES_H
#define MODBUS_VALUES_H

#include "modbus_map.h" /* struct map_entry */

enum { MAP_NOT_THERE = 0xFF };

/* The entry with this address; MAP_NOT_THERE unless `count` addresses from there on all are. There
 * is one at least. */
uint8_t map_find(const struct map_entry *table, uint8_t size, uint16_t address, uint16_t count);

uint16_t map_word(const struct map_entry *entry);
bool map_bit(const struct map_entry *entry);

/* A float in steps of 1 / `per_unit`, to nearest, held to -32767..32767. */
int16_t map_scaled(float value, float per_unit);

#endif
