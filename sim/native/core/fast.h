/* The processor's instructions: a burst of them, and the same while a profile is taken. */
#pragma once
#include "hw.h"

#define BURST 100000            /* most cycles in one burst: under 1 ms of wall time */
void fast_init(hw *h);
void fast_free(hw *h);
void fast_forget(hw *h);
int fast_mark(hw *h, uint32_t at);
avr_flashaddr_t fast_run(hw *h);
avr_flashaddr_t profiled_run(hw *h);
