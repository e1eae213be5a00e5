/* Stand-in for avr-libc: its CRCs as its manual gives them in C. */
#ifndef STATIC_CRC16_H
#define STATIC_CRC16_H

#include <stdint.h> /* uint8_t, uint16_t */

static inline uint16_t _crc16_update(uint16_t crc, uint8_t data)
{
    crc ^= data;
    for (uint8_t bit = 0; bit < 8; bit++) {
        crc = (uint16_t)(crc & 1u ? (crc >> 1) ^ 0xA001u : crc >> 1);
    }
    return crc;
}

static inline uint8_t _crc_ibutton_update(uint8_t crc, uint8_t data)
{
    crc ^= data;
    for (uint8_t bit = 0; bit < 8; bit++) {
        crc = (uint8_t)(crc & 1u ? (crc >> 1) ^ 0x8Cu : crc >> 1);
    }
    return crc;
}

#endif
