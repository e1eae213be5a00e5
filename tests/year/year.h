/* A machine around the host build, for as long as one likes: test_year.py tells how it is made. */
#ifndef YEAR_H
#define YEAR_H

enum { YEAR_STATES = 6, YEAR_INPUTS = 8 };

struct year_machine {
    void (*set)(uint8_t loop, const struct host_input *input);
    void (*tick)(void); /* of the loop alone: the outputs give what they are told to */
    uint32_t (*state)(uint8_t loop, uint8_t *to);
    uint32_t period_ticks;
    double step[2][YEAR_STATES][YEAR_INPUTS]; /* of the plant, by cooler off and on: states, W, °C */
    uint32_t states;
    uint32_t felt;       /* the state that the sensor follows */
    double late_steps;   /* its dead time */
    double noise_k;
    const double *normals; /* 1024 of them, by whose sums the readings are off */
    const double *edges_c; /* where codes end, rising */
    int32_t codes;
    int32_t lowest_code; /* below the first edge */
    int32_t code_step;   /* to the code above an edge; below 0: codes fall with temperature */
    uint32_t oversample; /* codes that are summed up to a reading */
    double full_w;
    double period_s;
    double ambient_c, day_k, season_k;
    double supply; /* share by which the supply goes up and down */
    double start_s; /* in the year */
    uint32_t duty_at, fault_at; /* places in the firmware's state */
    uint32_t cooling_at;        /* 0 without a cooler */
};

struct year_told {
    uint64_t steps; /* that were done; a fault ends it */
    uint8_t fault;
    double least_c, most_c; /* of the temperature that is felt, from `settled` on */
};

/* Hold a setpoint for so many steps from cold. The first `kept` inputs are written to `inputs`. */
void year(const struct year_machine *machine, float setpoint_c, uint64_t steps, uint64_t settled,
          uint64_t seed, uint32_t kept, struct host_input *inputs, struct year_told *told);

#endif
