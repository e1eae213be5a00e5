/* Stand-in for avr-libc: constants are in ordinary memory. */
#ifndef WORLD_PGMSPACE_H
#define WORLD_PGMSPACE_H

#include <stdint.h>
#include <string.h>

#define PROGMEM
#define pgm_read_byte(place) (*(const uint8_t *)(place))
#define pgm_read_word(place) (*(const uint16_t *)(place))
#define pgm_read_ptr(place) (*(void *const *)(place))
#define strcpy_P strcpy

#endif
