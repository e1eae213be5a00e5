/* Finds entries of the register map, and makes the words and bits that a master reads. */
#include "modbus_values.h"

#include <avr/pgmspace.h> /* pgm_read_* */
#include <string.h>       /* memcpy */
#include <util/atomic.h>  /* ATOMIC_BLOCK */

static const float TENTHS = 10.0f;
static const float HUNDREDTHS = 100.0f;
static const float LARGEST = 32767.0f;

uint8_t map_find(const struct map_entry *table, uint8_t size, uint16_t address, uint16_t count)
{
    uint8_t first = 0;

    while (first < size && pgm_read_word(&table[first].address) != address) {
        first++;
    }
    if (count > (uint16_t)(size - first)) {
        return MAP_NOT_THERE;
    }
    const uint16_t last = pgm_read_word(&table[first + (uint8_t)(count - 1u)].address);
    return (uint16_t)(last - address) == (uint16_t)(count - 1u) ? first : MAP_NOT_THERE;
}

int16_t map_scaled(float value, float per_unit)
{
    float steps = value * per_unit;

    steps += steps < 0.0f ? -0.5f : 0.5f;
    if (steps >= LARGEST) {
        return (int16_t)LARGEST;
    }
    return steps > -LARGEST ? (int16_t)steps : (int16_t)-LARGEST; /* NaN becomes the least value */
}

uint16_t map_word(const struct map_entry *entry)
{
    const void *const place = pgm_read_ptr(&entry->of.place);
    uint16_t word;

    switch (pgm_read_byte(&entry->how)) {
    case MAP_NUMBER:
        return pgm_read_word(&entry->of.number);
    case MAP_BYTE:
        return *(const uint8_t *)place;
    case MAP_TENTHS:
        return (uint16_t)map_scaled(*(const float *)place, TENTHS);
    case MAP_HUNDREDTHS:
        return (uint16_t)map_scaled(*(const float *)place, HUNDREDTHS);
    default:
        ATOMIC_BLOCK(ATOMIC_RESTORESTATE) /* an interrupt may change it */
        {
            memcpy(&word, place, sizeof word);
        }
        return word;
    }
}

bool map_bit(const struct map_entry *entry)
{
    const uint8_t *const place = pgm_read_ptr(&entry->of.place);

    return (*place & pgm_read_byte(&entry->how)) != 0;
}
