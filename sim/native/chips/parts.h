/* What processor.c asks of each chip at the pins. */
#pragma once
#include "core/hw.h"

void onewire_free(hw *h);
void spi_free(hw *h);
void relay_free(hw *h);
void fan_free(hw *h);
