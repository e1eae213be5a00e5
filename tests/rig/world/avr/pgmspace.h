/* As in the host build, and what only the firmware's texts for hosts take from flash. */
#ifndef RIG_PGMSPACE_H
#define RIG_PGMSPACE_H

#include_next <avr/pgmspace.h>

#ifndef pgm_read_ptr
#define pgm_read_ptr(place) (*(void *const *)(place))
#endif
#define strcpy_P strcpy

#endif
