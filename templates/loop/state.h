/* Bits of a loop's state. */

enum {
    STATE_WORK = 1, /* the loop is on, and no fault is latched */
    STATE_HEAT = 2, /* the duty of its heater is above 0 */
    STATE_COOL = 4, /* its cooler must run */
    STATE_WARM = 8  /* the loop works, and its last reading is good and near the setpoint */
};
