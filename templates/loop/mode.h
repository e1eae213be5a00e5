/* Who decides the duty of a loop that has a manual mode. */

enum {
    MODE_AUTOMATIC = 0, /* the algorithm sets the duty; a host's setpoint of 0 is off */
    MODE_MANUAL = 1,    /* the operator sets the duty */
    MODE_TUNING = 2     /* the relay experiment sets the duty */
};

/* The state of the autotuning. */
enum {
    AUTOTUNE_NONE = 0, /* no tuning since the reset */
    AUTOTUNE_RUNNING = 1,
    AUTOTUNE_DONE = 2, /* the gains found are in use, and stored */
    AUTOTUNE_TIMED_OUT = 3, /* it took too long, or an input paused the loop */
    AUTOTUNE_STOPPED = 4, /* a command or a fault ended it */
    AUTOTUNE_TOO_HOT = 5, /* the temperature rose too far above the target */
    AUTOTUNE_NO_USE = 6 /* the numbers found cannot be gains */
};
