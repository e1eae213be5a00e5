/* The commands of the log, and their answers. */
#ifndef LOG_TALK_H
#define LOG_TALK_H

#include <stdbool.h> /* bool */

/* True if something has been received, or is to be sent. */
bool log_talk_is_due(void);

/* Hear commands, and send the next line of an answer. */
void log_talk(void);

#endif
