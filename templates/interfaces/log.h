/* The log, read out over a serial port: each line is a command, and may be `log`, `clear` or `help`. */
#ifndef LOG_H
#define LOG_H

/* Once a tick: note what is due, hear commands, answer a line at a time. */
void log_tick(void);

#endif
