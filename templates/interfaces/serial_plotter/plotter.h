/* Sends one line per control step to the program Serial Port Plotter: `$` fields `;`. */
#ifndef PLOTTER_H
#define PLOTTER_H

/* Begin a line; if the last one is still being sent, it continues instead. */
void plotter_send(void);

/* Once per tick: send the next field. */
void plotter_tick(void);

#endif
