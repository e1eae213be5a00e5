/* The functions of each peripheral for processor.c: set up once, correct after a reset, free. */
#pragma once
#include "core/hw.h"

int pins_init(hw *h);
void pins_reset(hw *h);
void compare_init(hw *h);
void compare_reset(hw *h);
void compare_free(hw *h);
void uart_init(hw *h);
void uart_reset(hw *h);
void uart_free(hw *h);
void adc_init(hw *h);
void eeprom_init(hw *h);
void eeprom_reset(hw *h);
void watchdog_init(hw *h);
void old_reset(hw *h);
