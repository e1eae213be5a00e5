/* The monitors, for the interfaces that show them, numbered from 1. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t */

/* Number of the first monitor that warns; 0: none warns. */
uint8_t monitors_warning(void);

/* Number of monitors. */
uint8_t monitors_count(void);

/* The monitor's name, a string in flash. */
const char *monitors_name(uint8_t number);

bool monitors_warns(uint8_t number);

/* True if the monitor's last reading was good. */
bool monitors_is_heard(uint8_t number);

/* The monitor's last good reading, in degC. */
float monitors_celsius(uint8_t number);
