/* The program that moves a loop's setpoint: docs/control.md, "Programs". */
#ifndef PROGRAM_H
#define PROGRAM_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t, int16_t, uint16_t, uint32_t */

#include "programs.h" /* PROGRAM_OVER.., struct stored_program */

struct progress_record;

/* program.state */
enum {
    PROGRAM_IDLE = 0,
    PROGRAM_RUNNING = 1,
    PROGRAM_PAUSED = 2,
    PROGRAM_RETURNING = 3, /* on the way back to the setpoint; the clocks stand still */
    PROGRAM_RESTORING = 4, /* the power was cut: what happens depends on the first reading */
    PROGRAM_INTERRUPTED = 5 /* by a fault: kept until somebody resumes it */
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
    PROGRAM_STOPPED = 2, /* by the operator */
    PROGRAM_FAILED = 3,  /* by a fault */
    PROGRAM_TOO_FAR = 4,          /* it was interrupted, and the temperature has gone too far */
    PROGRAM_POWER_UNREADABLE = 5  /* the power was cut, and the program is another one now */
};

/* program.order */
enum {
    PROGRAM_NO_ORDER = 0,
    PROGRAM_STOP = 1,
    PROGRAM_PAUSE = 2,
    PROGRAM_START = 3,
    PROGRAM_RESUME = 4,
    PROGRAM_SKIP = 5,
    PROGRAM_JUMP = 6
};

/* As the last control step left it. A step of progress is one period of the loop. */
struct program_state {
    uint8_t state;
    uint8_t waiting;
    uint8_t ended;    /* why the last program is no longer there */
    uint8_t number;   /* its place */
    uint8_t segment;  /* from 1 */
    uint8_t segments; /* of the program */
    uint8_t order;    /* what the step has taken over */
    uint8_t argument;
    uint8_t leap;     /* the setpoint was put elsewhere, not moved */
    uint8_t kind;     /* of the segment: PROGRAM_OVER.. */
    int16_t to_dc;    /* as the program says it, 0.1 degC */
    uint32_t amount;  /* s, or 0.1 K/h */
    float first_c;    /* temperature at the program's start */
    float from_c;     /* where the segment's way begins */
    float to_c;       /* and ends */
    float setpoint_c;
    float before_c;   /* temperature before it was interrupted */
    float rate_k_per_s; /* of the setpoint */
    uint32_t length;  /* of the segment, steps */
    uint32_t elapsed; /* steps of progress in it */
    uint16_t waited;  /* steps, below the setpoint */
    uint32_t clock;   /* steps in the program, pauses apart */
    uint32_t segment_clock; /* steps in the segment, the same */
    uint32_t energy;  /* sum over the steps of the heater's duty in tenths of a percent */
};

extern struct program_state program;

/* What the operator orders; the next control step takes it over, if it must be with the next good
 * reading. False: it cannot be done now. */
bool program_start(uint8_t number);
bool program_pause(void);
bool program_resume(void);
bool program_skip(void);
bool program_jump(uint8_t segment);
bool program_stop(void);

/* Whether an order waits for the next step. */
bool program_is_ordered(void);

/* The program as it was when it was started: editing does not change the one that runs. */
const struct stored_program *program_loaded(void);

/* After a reset: go on where the power was cut, if the first reading allows it. */
void program_start_up(void);

/* One step of the loop; `ok` says whether its temperature is that of this step. */
void program_step(bool ok);

/* What the step has asked of the heater. */
void program_count(float duty_percent);

/* A fault is latched, or was acknowledged: whatever ran does not go on by itself. */
void program_fail(void);

/* What is needed to go on after a loss of power. */
void program_note(struct progress_record *record);

#endif
