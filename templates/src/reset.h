/* What the reset left behind, read before anything else runs. */
#ifndef RESET_H
#define RESET_H

#include <stdint.h> /* uint8_t */

/* Copy of MCUSR: PORF, EXTRF, BORF and WDRF of the last reset. */
extern uint8_t reset_cause;

/* Latch a fault if the watchdog or a brown-out caused the reset. */
void reset_report(void);

#endif
