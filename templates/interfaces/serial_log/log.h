/* The log, read out over a serial port: each received line is a command, such as `log`. */

/* Once per tick: add an entry if due, read commands, send at most one line of an answer. */
void log_tick(void);

/* Restart the time until the next entry. */
void log_begin_anew(void);
