/* Adds entries to the log. */

/* Add an entry with the loop's temperature and setpoint to the ring. */
void log_note(void);
