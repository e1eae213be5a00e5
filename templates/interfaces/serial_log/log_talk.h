/* The commands of the log, and their answers. */

#include <stdbool.h> /* bool */

/* True if a byte has been received, or something must be sent. */
bool log_talk_is_due(void);

/* Read commands, and send the next line of an answer. */
void log_talk(void);
