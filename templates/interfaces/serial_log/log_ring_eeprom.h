/* What a ring in EEPROM needs besides. */
#ifndef LOG_RING_EEPROM_H
#define LOG_RING_EEPROM_H

/* Before the first tick: find the newest entry. */
void log_ring_start(void);

/* Once a tick: write a byte, if there is one to be written and the EEPROM is free. */
void log_ring_tick(void);

#endif
