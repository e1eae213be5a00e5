/* Who this slave is: functions 17 and 43/14. */
#ifndef MODBUS_IDENTITY_H
#define MODBUS_IDENTITY_H

#include <stdint.h> /* uint8_t, uint16_t */

/* Function 17: the length of the answer. */
uint8_t identity_report(void);

/* Function 43 with a request of this length: MODBUS_DONE and the length of the answer, or the
 * exception. */
uint8_t identity_objects(uint16_t length, uint8_t *answer_length);

#endif
