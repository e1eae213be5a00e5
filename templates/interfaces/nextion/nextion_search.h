/* Sets a touch display with another baud rate to the baud rate of this line. */

#include <stdbool.h> /* bool */

/* Start the search, when the display does not answer: send the instruction at each baud rate. */
void search_begin(void);

/* True while the search uses the line. */
bool search_is_on(void);

/* One turn of the search; true while it uses the line. The last turn restores the baud rate. */
bool search_turn(void);
