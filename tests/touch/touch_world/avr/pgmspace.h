/* As in the host build, and pointers that are in flash. */
#ifndef TOUCH_PGMSPACE_H
#define TOUCH_PGMSPACE_H

#include_next <avr/pgmspace.h>

#ifndef pgm_read_ptr
#define pgm_read_ptr(place) (*(const void *const *)(place))
#endif

#endif
