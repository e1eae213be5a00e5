/* Identification of this slave: functions 17 and 43/14. */

#include <stdint.h> /* uint8_t, uint16_t */

/* Function 17: write the answer, and return its length. */
uint8_t identity_report(void);

/* Function 43, for a request of this length: write the answer and its length, and return MODBUS_DONE;
 * or return the exception's code. */
uint8_t identity_objects(uint16_t length, uint8_t *answer_length);
