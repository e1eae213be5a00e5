/* What the reset left behind, read before anything else runs. */
#ifndef RESET_H
#define RESET_H

#include <stdint.h> /* uint8_t */

/* Copy of MCUSR: PORF, EXTRF, BORF and WDRF of the last reset. */
extern uint8_t reset_cause;

/* RESET_HANG_MARK while the main loop has stood still for longer than its permit at the gate. */
enum { RESET_HANG_MARK = 0x5AC3 };
extern volatile uint16_t reset_hang_mark;

/* Latch a fault if the watchdog or a brown-out caused the reset. */
void reset_report(void);

#endif
