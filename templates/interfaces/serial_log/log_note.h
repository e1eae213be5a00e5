/* An entry of the log. */
#ifndef LOG_NOTE_H
#define LOG_NOTE_H

/* Put what the loop reads, and what it shall, into the ring. */
void log_note(void);

#endif
