/* One line a control step for the program Serial Port Plotter: `$` fields `;`. */
#ifndef PLOTTER_H
#define PLOTTER_H

/* Begin a line; one that is still being sent goes on. */
void plotter_send(void);

/* Once a tick: send the next field. */
void plotter_tick(void);

#endif
