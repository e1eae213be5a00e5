/* The core while a profile is taken: fast.c once more, with what the profile has to hear of.

   Of straight code and of jumps within a function and a window it hears nothing but how far they
   went; what is left to simavr is noted around that instruction, as with simavr's core. */
#include "profile.h"

#define PROFILED(...) __VA_ARGS__
#define fast_run profiled_run
#include "fast.c"
