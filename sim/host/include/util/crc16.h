/* Stand-in for avr-libc: the CRC of Modbus, as its manual gives it in C. */
#ifndef HOST_CRC16_H
#define HOST_CRC16_H

#include <stdint.h> /* uint8_t, uint16_t */

static inline uint16_t _crc16_update(uint16_t crc, uint8_t data)
{
    crc ^= data;
    for (uint8_t bit = 0; bit < 8; bit++) {
        crc = (uint16_t)(crc & 1u ? (crc >> 1) ^ 0xA001u : crc >> 1);
    }
    return crc;
}

#endif
