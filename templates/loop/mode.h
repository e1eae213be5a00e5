/* Who decides the duty of a loop that a host commands. */
#ifndef MODE_H
#define MODE_H

enum {
    MODE_AUTOMATIC = 0, /* the algorithm; with a setpoint of 0 the loop is off */
    MODE_MANUAL = 1,    /* the operator */
    MODE_TUNING = 2     /* the relay experiment */
};

/* How the search for gains stands. */
enum {
    AUTOTUNE_NONE = 0, /* there was none since the reset */
    AUTOTUNE_RUNNING = 1,
    AUTOTUNE_DONE = 2, /* the gains found are in use, and kept */
    AUTOTUNE_TIMED_OUT = 3,
    AUTOTUNE_STOPPED = 4, /* by a command or a fault */
    AUTOTUNE_TOO_HOT = 5,
    AUTOTUNE_NO_USE = 6 /* what was found cannot be a gain */
};

#endif
