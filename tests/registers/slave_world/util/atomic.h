/* Stand-in for avr-libc: no interrupt comes between two statements here. */
#ifndef WORLD_ATOMIC_H
#define WORLD_ATOMIC_H

#define ATOMIC_RESTORESTATE
#define ATOMIC_BLOCK(how) for (int once = 1; once; once = 0)

#endif
