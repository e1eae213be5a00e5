/* Stand-in for avr-libc: `pointed` writes ATOMIC_BLOCK out. */
#include "harness.h"
