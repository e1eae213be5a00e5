/* What the host build's firmware sees of the world, and what Python sees of the firmware. */
#ifndef HOST_WORLD_H
#define HOST_WORLD_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t, int16_t, int32_t, uint32_t */

#define JOINED(a, b, c) a##b##c
#define JOIN(a, b, c) JOINED(a, b, c)

/* What is done before one control step of a loop, and what the sensor says in it. */
struct host_input {
    uint8_t reading_status;
    uint8_t acknowledge; /* acts before the command */
    int32_t reading_raw; /* of any sensor */
    float setpoint_c; /* of a loop that no host commands; else see HOST_SET */
    uint8_t command;
    float value;
    float gains[3]; /* kp, ki, kd; of HOST_LIMITS the integral's minimum and maximum, the output's */
    uint8_t current_status;
    int16_t current_raw;
    uint16_t silent_ticks; /* since the master, or the host, was heard */
    uint8_t order; /* to the program: PROGRAM_* of program.order */
    uint8_t argument;
    uint8_t open_inputs; /* of the machine, by their bits: of the first loop's, until its next step */
    uint8_t monitored; /* monitors of the loop: which of their readings, or HOST_BAD + a status; and
                        * HOST_ONLY * n: only the n-th, the others have their first reading */
};

enum { HOST_READINGS = 9, HOST_BAD = 16, HOST_ONLY = 64 };

/* Commands to a loop that a host or a master commands. */
enum {
    HOST_NOTHING = 0,
    HOST_SET = 1,    /* a setpoint of `value` */
    HOST_MANUAL = 2, /* a duty of `value` */
    HOST_TUNE = 3,   /* about `value`, in gains[0] cycles */
    HOST_STOP_TUNING = 4,
    HOST_GAINS = 5,
    HOST_KEEP = 6,
    HOST_RELOAD = 7,
    HOST_DEFAULTS = 8,
    HOST_EMERGENCY = 9,
    HOST_ENABLE = 10,
    HOST_DISABLE = 11,
    HOST_PERCENT = 12, /* a duty by hand of `value`, now or later */
    HOST_AUTOMATIC = 13,
    HOST_MAXIMUM = 14, /* a critical temperature of `value` */
    HOST_NUMBERS = 15, /* what keys set of the algorithm, one by one, in `gains`: unbounded, as RAM is */
    HOST_LIMITS = 16   /* limits of integral and output */
};

/* One loop, as world.c sees it; all of it is as at power-up after a reset. */
struct host_loop {
    void (*off)(void);   /* its pins */
    void (*start)(void); /* its part of what main.c does to start */
    void (*tick)(void);
    bool (*command)(const struct host_input *asked); /* false if the firmware refuses it */
    uint32_t (*heater)(void); /* what drives it now: 1 if its pin is on; the counts of each period
                               * where a timer may */
    bool (*cools)(void);
    uint32_t (*state)(uint8_t *to);
    const uint16_t *steps; /* control steps so far */
    uint32_t period_ticks;
    uint8_t fan_port;
    uint8_t fan_mask;
    uint8_t fan_off;
    struct host_input input;
    uint32_t heater_counts; /* by which the heater was on, over all ticks */
};

/* What one loop is to do, and what it did. */
struct host_course {
    const struct host_input *inputs;
    uint32_t steps;
    uint8_t *states;       /* takes the state after each step */
    uint32_t *counts;      /* takes the heater's counts so far */
    uint32_t done;         /* steps; 0 before */
    uint32_t waited_ticks; /* for the next one; 0 before */
};

/* Survives a reset of the firmware. Ticks and counts are sums over all loops. */
struct host_world {
    uint8_t main_hangs;       /* only the timer interrupt still comes */
    uint8_t loop_hangs;       /* the main loop runs, the control step is never due */
    uint8_t fan_stands_still; /* nothing drives the fan's line */
    uint16_t proof_line;      /* what proves that fans turn: HOST_*, or looks at it that a pulse lasts */
    uint8_t open_inputs;      /* of the machine, by their bits; 0 at power-up */
    uint8_t pull_ups_flip;    /* theirs, and their directions, in each tick behind the gate */
    uint32_t looks;           /* at it, since the reset */
    uint32_t ticks;           /* since the reset */
    uint32_t heater_counts;   /* by which the heater was on, over all ticks since the reset */
    uint8_t eeprom[4096];
    uint16_t eeprom_bytes;
    uint32_t eeprom_outside;  /* accesses beyond them */
    uint32_t eeprom_writes;
    int32_t writes_left;      /* until the power fails; below 0: it does not */
    uint8_t refused;          /* the last command was */
    uint8_t order_refused;    /* the last order to the program was */
    uint32_t cooler_ticks;    /* in which the cooler was on, since the reset */
    uint32_t both_on;         /* ticks in which heater and cooler were */
    uint32_t feed_halts;      /* ticks in which the gate stopped the feed */
    int16_t torn;             /* what the write that it fails in leaves; below 0: the old byte */
};

enum { HOST_PROVES = 0, HOST_TORN = 1, HOST_SHORTED = 2 };

struct host_world *host_world(void);

/* All the firmware's memory as at power-up, then what main.c does to start. */
void host_power_up(void);

/* One timer interrupt, then one turn of the main loop. */
void host_tick(void);

/* Put the inputs at the disposal of a loop's next step; loops count from 0. */
/* As a person at the machine does: trips count anew. */
void host_acknowledge(void);

void host_set(uint8_t loop, const struct host_input *input);

/* A loop's state structures, one behind the other: loop, guard, algorithm, fault, output, autotune,
 * current, program; of a commanded loop whether it is ready, or its state, too. */
uint32_t host_state(uint8_t loop, uint8_t *to);

/* Run the courses, one for each loop. Each input is given when the loop's last step is done, and with
 * it the tick. A loop whose course is done goes on with its last input. It ends early if a step does
 * not come. */
void host_run(struct host_course *courses);

/* Save at once: as many ticks as the firmware takes to have written everything, 2000 at most. */
void host_settle(void);

#endif
