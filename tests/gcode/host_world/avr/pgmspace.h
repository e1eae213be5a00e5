/* Stand-in for avr-libc: constants are in ordinary memory. */
#ifndef WORLD_PGMSPACE_H
#define WORLD_PGMSPACE_H

#include <stdint.h>

#define PROGMEM
#define PSTR(text) (text)
#define pgm_read_byte(place) (*(const uint8_t *)(place))
#define pgm_read_dword(place) (*(const uint32_t *)(place))
#define pgm_read_float(place) (*(const float *)(place))
#define pgm_read_ptr(place) (*(const void *const *)(place))

#endif
