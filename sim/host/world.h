/* The interface of the host build: the world for the firmware, and the firmware for Python. */
#ifndef HOST_WORLD_H
#define HOST_WORLD_H

#include <stdbool.h> /* bool */
#include <stdint.h>  /* uint8_t, int16_t, int32_t, uint32_t */

#define JOINED(a, b, c) a##b##c
#define JOIN(a, b, c) JOINED(a, b, c)

/* The inputs of one control step of a loop, and the sensor's reading in it. */
struct host_input {
    uint8_t reading_status;
    uint8_t acknowledge; /* acts before the command */
    int32_t reading_raw; /* the raw number of any kind of sensor */
    float setpoint_c; /* used only without a host; otherwise see HOST_SET */
    uint8_t command;
    float value;
    float gains[3]; /* kp, ki, kd; for HOST_LIMITS: integral minimum and maximum, output maximum */
    uint8_t current_status;
    int16_t current_raw;
    uint16_t silent_ticks; /* since the last message of the master or host */
    uint8_t order; /* command to the program: PROGRAM_* of program.order */
    uint8_t argument;
    uint8_t open_inputs; /* the machine's open inputs, by bits: only those of the first loop are used */
    uint8_t monitored; /* index of the monitors' readings, or HOST_BAD + a status;
                        * HOST_ONLY * n: for the n-th only, others have their first reading */
};

enum { HOST_READINGS = 9, HOST_BAD = 16, HOST_ONLY = 64 };

/* Commands to a loop that a host or a master commands. */
enum {
    HOST_NOTHING = 0,
    HOST_SET = 1,    /* set the setpoint to `value` */
    HOST_MANUAL = 2, /* set the manual duty to `value` */
    HOST_TUNE = 3,   /* tune at `value`, with gains[0] cycles */
    HOST_STOP_TUNING = 4,
    HOST_GAINS = 5,
    HOST_KEEP = 6,
    HOST_RELOAD = 7,
    HOST_DEFAULTS = 8,
    HOST_EMERGENCY = 9,
    HOST_ENABLE = 10,
    HOST_DISABLE = 11,
    HOST_PERCENT = 12, /* set the manual duty to `value`; it acts while the mode is manual */
    HOST_AUTOMATIC = 13,
    HOST_MAXIMUM = 14, /* set the critical temperature to `value` */
    HOST_NUMBERS = 15, /* write `gains` to the keypad's numbers without a check, like a fault of the RAM */
    HOST_LIMITS = 16   /* set the limits of integral and output */
};

/* One loop for world.c; a reset restores it to its state at power-up. */
struct host_loop {
    void (*off)(void);   /* switches its pins off */
    void (*start)(void); /* does its part of main.c's start-up */
    void (*tick)(void);
    bool (*command)(const struct host_input *asked); /* returns false if the firmware refuses */
    uint32_t (*heater)(void); /* 1 if its pin is on; for a pin that a timer drives, the on-counts
                               * of each period */
    bool (*cools)(void);
    uint32_t (*state)(uint8_t *to);
    const uint16_t *steps; /* control steps so far */
    uint32_t period_ticks;
    uint8_t fan_port;
    uint8_t fan_mask;
    uint8_t fan_off;
    struct host_input input;
    uint32_t heater_counts; /* ticks or timer counts with the heater on, over all ticks */
};

/* The inputs of one loop, and its results. */
struct host_course {
    const struct host_input *inputs;
    uint32_t steps;
    uint8_t *states;       /* receives the state after each step */
    uint32_t *counts;      /* receives the heater's counts so far */
    uint32_t done;         /* steps done; 0 at the start */
    uint32_t waited_ticks; /* ticks waited for the next step; 0 at the start */
};

/* Survives a reset of the firmware. Heaters and coolers are counted over all loops. */
struct host_world {
    uint8_t main_hangs;       /* only the timer interrupt still runs */
    uint8_t loop_hangs;       /* the main loop runs, the control step is never due */
    uint8_t fan_stands_still; /* nothing drives the fan's line */
    uint16_t proof_line;      /* HOST_PROVES to HOST_SHORTED, or reads per pulse */
    uint8_t open_inputs;      /* the machine's open inputs, by their bits; 0 at power-up */
    uint8_t pull_ups_flip;    /* the inputs lose pull-up and direction after each `gate_tick` */
    uint32_t looks;           /* reads of the proofs' lines since the reset */
    uint32_t ticks;           /* since the reset */
    uint32_t heater_counts;   /* ticks or timer counts with the heater on, since the reset */
    uint8_t eeprom[4096];
    uint16_t eeprom_bytes;
    uint32_t eeprom_outside;  /* accesses outside the EEPROM */
    uint32_t eeprom_writes;
    int32_t writes_left;      /* EEPROM writes until the power fails; below 0: never */
    uint8_t refused;          /* whether the last command was refused */
    uint8_t order_refused;    /* whether the last command to the program was refused */
    uint32_t cooler_ticks;    /* ticks with the cooler on since the reset */
    uint32_t both_on;         /* ticks with heater and cooler both on */
    uint32_t feed_halts;      /* ticks in which the gate stopped the feed */
    int16_t torn;             /* byte left by the interrupted write; below 0: the old byte */
};

enum { HOST_PROVES = 0, HOST_TORN = 1, HOST_SHORTED = 2 };

struct host_world *host_world(void);

/* Restores all the firmware's memory to power-up, then does main.c's start-up. */
void host_power_up(void);

/* Runs one timer interrupt, then one turn of the main loop. */
void host_tick(void);

/* Acknowledges as a person at the machine: the count of trips restarts. */
void host_acknowledge(void);

/* Sets the inputs of a loop's next step; loops count from 0. */
void host_set(uint8_t loop, const struct host_input *input);

/* Copies a loop's state structures, one after the other: loop, guard, algorithm, fault, output,
 * autotune, current, program, response, monitors; for a commanded loop also `ready` or `state`. */
uint32_t host_state(uint8_t loop, uint8_t *to);

/* Runs the courses, one for each loop. Each input is set when the loop's last step and its tick are
 * done. A loop whose course is done repeats its last input. The run ends early if a step does not
 * come. */
void host_run(struct host_course *courses);

/* Runs the parts that write to the EEPROM until everything is written, for at most 2000 ticks. */
void host_settle(void);

#endif
