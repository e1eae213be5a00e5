/* The functions of pins for other peripherals, and for the chips at the pins. */
#pragma once
#include "core/hw.h"

void pin_update(hw *h, int pin);
void pin_hold(hw *h, int pin, int high, int held);
int pin_listen(hw *h, int pin, struct wire_listener listener);
void pin_follow(hw *h, int pin, struct pin_follower follower);
