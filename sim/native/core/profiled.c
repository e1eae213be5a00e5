/* The core during a profile: fast.c again, with the calls of the profile.

   Straight code and jumps within a function and a window are reported only by how far they went.
   Instructions that are left to simavr are reported one by one, as with simavr's core. */
#include "profile.h"

#define PROFILED(...) __VA_ARGS__
#define fast_run profiled_run
#include "fast.c"
