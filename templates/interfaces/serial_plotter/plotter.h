/* Sends one line per control step to the program Serial Port Plotter: `$` fields `;`. */

/* Begin a line; if the last line is still being sent, do nothing. */
void plotter_send(void);

/* Once per tick: send the next field. */
void plotter_tick(void);
