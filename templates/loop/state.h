/* What a loop is doing, one bit each. */
#ifndef STATE_H
#define STATE_H

enum {
    STATE_WORK = 1, /* it is switched on, and no fault is latched */
    STATE_HEAT = 2, /* its heater is asked for heat */
    STATE_COOL = 4, /* its cooler is asked for */
    STATE_WARM = 8  /* it works, and the last reading was good and near its setpoint */
};

#endif
