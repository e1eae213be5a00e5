/* Stand-in for avr-libc: on the host, constants are in ordinary memory. */
#ifndef HOST_PGMSPACE_H
#define HOST_PGMSPACE_H

#include <stdint.h> /* uint8_t, uint16_t, uint32_t */
#include <string.h> /* memcpy */

#define PROGMEM
#define PSTR(text) (text)
#define pgm_read_byte(place) (*(const uint8_t *)(place))
#define pgm_read_word(place) (*(const uint16_t *)(place))
#define pgm_read_float(place) (*(const float *)(place))
#define pgm_read_dword(place) (*(const uint32_t *)(place))
#define memcpy_P(to, place, size) memcpy(to, place, size)

#endif
