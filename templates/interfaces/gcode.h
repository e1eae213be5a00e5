/* The G-code that a host sends, and what it does here: docs/gcode.md of heatwright. */
#ifndef GCODE_H
#define GCODE_H

void gcode_start(void);

/* Once a tick: one line at most. */
void gcode_tick(void);

#endif
