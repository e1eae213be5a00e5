/* Stand-in for avr-libc: no interrupt comes between two statements on the host. */
#ifndef HOST_ATOMIC_H
#define HOST_ATOMIC_H

#define ATOMIC_RESTORESTATE
#define ATOMIC_BLOCK(how) for (int host_once = 1; host_once; host_once = 0)

#endif
