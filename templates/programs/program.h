/* The program that moves a loop's setpoint: docs/control.md, "Programs". */

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t, int16_t, uint16_t, uint32_t */

#include "programs.h" /* PROGRAM_OVER.., struct stored_program */

struct progress_record;

/* program.state */
enum {
    PROGRAM_IDLE = 0,
    PROGRAM_RUNNING = 1,
    PROGRAM_PAUSED = 2,
    PROGRAM_RETURNING = 3, /* the temperature returns to the setpoint after a break; clocks stopped */
    PROGRAM_RESTORING = 4, /* after a power cut: the first reading decides whether it continues */
    PROGRAM_INTERRUPTED = 5 /* a fault came: the program waits until the operator resumes it */
};

/* program.waiting */
enum {
    PROGRAM_WAITS_FOR_NOTHING = 0,
    PROGRAM_HELD_BACK = 1, /* the temperature is too far from the setpoint */
    PROGRAM_FOR_TARGET = 2,
    PROGRAM_FOR_OPERATOR = 3
};

/* program.ended */
enum {
    PROGRAM_NOT_ENDED = 0,
    PROGRAM_FINISHED = 1,
    PROGRAM_STOPPED = 2, /* the operator ended it */
    PROGRAM_FAILED = 3,  /* a fault ended it */
    PROGRAM_TOO_FAR = 4,          /* it was interrupted, and the temperature has changed too much */
    PROGRAM_POWER_UNREADABLE = 5  /* after a power cut, record and stored program do not match */
};

/* program.order: two codes differ in at least two bits: one flipped bit makes no other command. */
enum {
    PROGRAM_NO_ORDER = 0,
    PROGRAM_STOP = 3,
    PROGRAM_PAUSE = 5,
    PROGRAM_START = 6,
    PROGRAM_RESUME = 9,
    PROGRAM_SKIP = 10,
    PROGRAM_JUMP = 12
};

/* The state after the last control step. A step of progress is one period of the loop. */
struct program_state {
    uint8_t state;
    uint8_t waiting;
    uint8_t ended;    /* why the last program ended */
    uint8_t number;   /* the place of the program */
    uint8_t segment;  /* number of the present segment, from 1 */
    uint8_t segments; /* number of segments in the program */
    uint8_t order;    /* the command that this step executes */
    uint8_t argument;
    uint8_t leap;     /* the setpoint jumped in this step */
    uint8_t kind;     /* kind of the segment: PROGRAM_OVER and so on */
    int16_t to_dc;    /* the segment's target, 0.1 degC */
    uint32_t amount;  /* the segment's time or rate: s, or 0.1 K/h */
    float first_c;    /* temperature at the program's start */
    float from_c;     /* setpoint at the segment's start */
    float to_c;       /* setpoint at its end */
    float setpoint_c;
    float before_c;   /* temperature before the interruption */
    float rate_k_per_s; /* slope of the setpoint */
    uint32_t length;  /* length of the segment, steps */
    uint32_t elapsed; /* steps of progress in the segment */
    uint16_t waited;  /* steps in which the segment waited, because the machine was too cold */
    uint32_t clock;   /* steps in the program without pauses */
    uint32_t segment_clock; /* steps in the segment without pauses */
    uint32_t energy;  /* sum over the steps of the heater's duty in tenths of a percent */
};

extern struct program_state program;

/* Commands of the operator, executed in the next control step, or in the next with a good reading if
 * the command needs one. False: the command cannot be executed now. */
bool program_start(uint8_t number);
bool program_pause(void);
bool program_resume(void);
bool program_skip(void);
bool program_jump(uint8_t segment);
bool program_stop(void);

/* True if a command waits for the next step. */
bool program_is_ordered(void);

/* The program as it was at its start: editing does not change the running program. */
const struct stored_program *program_loaded(void);

/* After a reset: continue where the power was cut, if the first reading allows it. */
void program_start_up(void);

/* One step; `ok`: the temperature is that of this step; `sound`: the settings are sound. */
void program_step(bool ok, bool sound);

/* Add the duty of this step to the program's energy. */
void program_count(float duty_percent);

/* A fault was latched or acknowledged: a program must not continue by itself. */
void program_fail(void);

/* Write into `record` what is needed to continue after a loss of power. */
void program_note(struct progress_record *record);
