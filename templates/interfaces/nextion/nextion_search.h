/* Sets a touch display with another baud rate to the baud rate of this line. */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint16_t */

/* Start the search, when the display does not answer: send the instruction at each baud rate. */
void search_begin(void);

/* True while the search uses the line. */
bool search_is_on(void);

/* The divisor of the baud rate that the line has now. */
uint16_t search_divisor(void);

/* One turn of the search; true while it uses the line. The last turn restores the baud rate. */
bool search_turn(void);
