/* Stand-in for avr-libc: constants are in ordinary memory, where their bounds are seen. */
#ifndef STATIC_PGMSPACE_H
#define STATIC_PGMSPACE_H

#include <stdint.h> /* uint8_t, uint16_t, uint32_t */
#include <string.h> /* memcpy */

#define PROGMEM
#define PSTR(text) (text)
#define pgm_read_byte(place) (*(const uint8_t *)(place))
#define pgm_read_word(place) (*(const uint16_t *)(place))
#define pgm_read_dword(place) (*(const uint32_t *)(place))
#define pgm_read_float(place) (*(const float *)(place))
#define pgm_read_ptr(place) (*(const void *const *)(place))
#define memcpy_P(to, from, size) memcpy(to, from, size)
#define strcpy_P(to, from) strcpy(to, from)
#define strcat_P(to, from) strcat(to, from)

#endif
