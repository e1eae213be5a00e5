/* The log, read out over a serial port: each line is a command, such as `log`. */
#ifndef LOG_H
#define LOG_H

/* Once a tick: note what is due, hear commands, answer a line at a time. */
void log_tick(void);

/* The time to the next entry begins now. */
void log_begin_anew(void);

#endif
