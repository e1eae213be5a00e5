/* Stand-in for avr-libc: the C that its documentation gives for the assembly. */
#ifndef WORLD_CRC16_H
#define WORLD_CRC16_H

#include <stdint.h>

static inline uint16_t _crc16_update(uint16_t crc, uint8_t byte)
{
    crc ^= byte;
    for (int bit = 0; bit < 8; bit++) {
        crc = (uint16_t)(crc & 1u ? (crc >> 1) ^ 0xA001u : crc >> 1);
    }
    return crc;
}

#endif
