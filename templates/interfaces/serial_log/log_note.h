/* Adds entries to the log. */
#ifndef LOG_NOTE_H
#define LOG_NOTE_H

/* Add an entry with the loop's temperature and setpoint to the ring. */
void log_note(void);

#endif
