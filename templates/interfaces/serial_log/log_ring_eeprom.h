/* Functions that the log's ring of entries has only in EEPROM. */

/* Before the first tick: find the newest entry. */
void log_ring_start(void);

/* Once per tick: write one byte, if one is due and the EEPROM is free. */
void log_ring_tick(void);
