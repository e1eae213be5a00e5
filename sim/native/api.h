/* The interface to Python. cffi reads this file, so it has only declarations. */

typedef struct hw hw;

/* Results of hw_run. */
enum {
    HW_DONE = 0,     /* the requested cycle is reached */
    HW_YIELD = 1,    /* some wall time has passed, or a log must be emptied: call again */
    HW_CRASHED = 2,  /* the CPU left its flash or RAM: see hw_message */
    HW_LIMIT = 3,    /* the firmware uses a feature that simavr does not model: see hw_message */
};

/* Other results of hw_machine_go: each names what Python must provide before the next call. */
enum {
    HW_MATRIX = 4,   /* the matrix of the present key is missing */
    HW_NOISE = 5,    /* all noise is used */
    HW_LOGGED = 6,   /* the log is full */
    HW_WAKE = 7,     /* a part outside has to act within this step */
    HW_FEED = 8,     /* a step has ended, and a part outside needs the records */
    HW_STOPPED = 9,  /* a step has ended, and the stop condition may be true */
    HW_NEWS = 10,    /* the board has sent something, and the part that waits for it looks now */
};

/* Causes of a reset, as MCUSR numbers them. */
enum { HW_POWER_ON = 0, HW_EXTERNAL = 1, HW_BROWN_OUT = 2, HW_WATCHDOG = 3 };

/* Logs, see hw_log_data. */
enum { HW_PIN_LOG = 0, HW_UART_LOG, HW_RESET_LOG, HW_ENTRY_LOG, HW_SNAPSHOT_LOG, HW_LOGS = 16 };

typedef struct { uint64_t cycle; uint8_t pin, state, pad[6]; } hw_pin_event;
/* format: data bits | parity (as UPM) << 4 | two stop bits << 6 | ninth bit << 7 */
typedef struct {
    uint64_t written, end;
    uint8_t uart, value, lost, format;
    uint32_t bit_cycles;
} hw_uart_byte;
typedef struct { uint64_t cycle; uint32_t pc; uint8_t cause, mcusr, pad[2]; } hw_reset_event;
typedef struct { uint64_t cycle; uint32_t pc, pad; } hw_entry;

/* One processor. mcu: simavr's name. NULL when simavr does not know it. */
hw *hw_new(const char *mcu, uint32_t clock_hz, uint32_t supply_mv);
void hw_free(hw *h);
const char *hw_message(hw *h);
uint32_t hw_flash_size(hw *h);
uint32_t hw_ram_end(hw *h);
uint8_t *hw_ram(hw *h);
uint8_t *hw_flash(hw *h);
void hw_jump(hw *h, uint32_t pc);
void hw_poke(hw *h, uint16_t address, uint8_t value);
void hw_sleep_register(hw *h, uint16_t address, uint8_t enable, uint8_t mode);
void hw_old_part(hw *h);                /* an ATmega16 or 32 */
void hw_flash_changed(hw *h);
void hw_reference_core(hw *h, int on);  /* simavr's own instruction core */
int hw_run(hw *h, uint64_t until);
int hw_run_to_code(hw *h, uint32_t start, uint32_t end, uint64_t until);
uint64_t hw_cycle(hw *h);
uint64_t hw_sleep_cycles(hw *h);
uint32_t hw_program_counter(hw *h);
uint16_t hw_stack_pointer(hw *h);
uint8_t hw_flags(hw *h);
int hw_asleep_for_good(hw *h);
void hw_reset(hw *h, int cause);

/* Logs. */
const void *hw_log_data(hw *h, int log);
size_t hw_log_count(hw *h, int log);
void hw_log_clear(hw *h, int log);

/* Pins. A pin is 8 * (port letter - 'A') + bit. */
enum { HW_NONE = 0, HW_LOW = 1, HW_HIGH = 2 };
enum { HW_BY_MCU = 0, HW_BY_OTHERS, HW_BY_RESISTOR, HW_BY_PULL_UP, HW_FLOATING };
int hw_pin_watch(hw *h, int pin, int logged);
int hw_pin_drive(hw *h, int pin, int level);
int hw_pin_pull(hw *h, int pin, int level);
int hw_pin_state(hw *h, int pin);
uint64_t hw_pin_high_cycles(hw *h, int pin);
uint64_t hw_pin_rises(hw *h, int pin);
uint64_t hw_pin_contention_cycles(hw *h, int pin);
int hw_pin_listen(hw *h, int pin, void *handle);  /* calls hw_pin_edge at edges that no chip makes */
void hw_pin_hold(hw *h, int pin, int held);       /* low, as a chip with an open drain does */

/* UART. A character to the UART: levels of its bits, the start bit lowest; times in cycles. */
typedef struct {
    double gap, bit;
    uint16_t levels;
    uint8_t bits, pad[5];
} hw_uart_character;
void hw_uart_send(hw *h, int uart, const hw_uart_character *characters, size_t count);
size_t hw_uart_unsent(hw *h, int uart);
void hw_uart_unsend(hw *h, int uart);
int hw_uart_exists(hw *h, int uart);
double hw_uart_frame_cycles(hw *h, int uart);
uint64_t hw_uart_overruns(hw *h, int uart);

/* ADC. A curve: voltages at equal distances of a sensor's value, interpolated linearly. */
void hw_adc_set(hw *h, int channel, double millivolts);
void hw_adc_curve(hw *h, int channel, const double *millivolts, size_t count, double first,
                  double per_unit);
int hw_adc_sense(hw *h, int channel, double felt);  /* returns 0 beyond the curve or without one */
double hw_adc_felt(hw *h, int channel);
void hw_adc_reference(hw *h, double aref_mv, double avcc_mv);
void hw_adc_mux5(hw *h, uint8_t mask);
void hw_adc_known(hw *h, uint8_t code, double millivolts);
void hw_adc_fail(hw *h, int hung, int stuck);
uint64_t hw_adc_conversions(hw *h);

/* EEPROM. */
int hw_eeprom_size(hw *h);
void hw_eeprom_get(hw *h, uint8_t *into);
void hw_eeprom_set(hw *h, const uint8_t *from);
void hw_eeprom_write_time(hw *h, double seconds);
int hw_eeprom_writing(hw *h, uint16_t *address, uint8_t *old, uint8_t *new_value);
uint64_t hw_eeprom_writes(hw *h);
uint64_t hw_eeprom_violations(hw *h);

/* Snapshots: copies of a RAM range, made when the counter has changed as the CPU goes to sleep, or
   comes to an address of the code, the same one for all. */
enum { HW_AT_SLEEP = 1 };      /* no code has an odd address */
int hw_snapshot(hw *h, uint16_t counter, uint8_t counter_size, uint16_t base, uint16_t size,
                uint32_t at);

/* A time of a bus's master, in cycles: the shortest and the longest, and how often it was wrong. */
typedef struct { uint64_t least, most, violations; } hw_check;

/* 1-Wire: one slave on a pin. Times in cycles. */
typedef struct {
    uint64_t reset_low, reset_high;             /* master: least reset low and high */
    uint64_t slot, recovery, low_least;         /* master: least slot, recovery, low */
    uint64_t one_most, zero_least, zero_most;   /* master: low of a 1, low of a 0 */
    uint64_t read_within;                       /* master: samples a read slot within */
    uint64_t presence_wait, presence_low;       /* slave: presence pulse */
    uint64_t sample, hold;                      /* slave: samples after, holds a 0 for */
} hw_onewire_timing;

/* The checked times of the master. */
enum {
    HW_OW_RESET_LOW = 0, HW_OW_RESET_HIGH, HW_OW_SLOT, HW_OW_RECOVERY, HW_OW_ONE_LOW,
    HW_OW_ZERO_LOW, HW_OW_READ_AT, HW_OW_CHECKS
};

typedef struct hw_onewire hw_onewire;
hw_onewire *hw_onewire_new(hw *h, int pin, void *handle, const hw_onewire_timing *timing);
void hw_onewire_retime(hw_onewire *w, const hw_onewire_timing *timing);
void hw_onewire_connect(hw_onewire *w, int connected);
void hw_onewire_ignore(hw_onewire *w);
void hw_onewire_receive(hw_onewire *w, int bits);
void hw_onewire_send(hw_onewire *w, const uint8_t *data, int bits);
void hw_onewire_busy(hw_onewire *w, uint64_t until);
void hw_onewire_search(hw_onewire *w, const uint8_t *rom);
const hw_check *hw_onewire_checks(hw_onewire *w);       /* HW_OW_CHECKS of them */
uint64_t hw_onewire_resets(hw_onewire *w);

/* SPI: one slave, on three pins if it only sends, on four if it has registers. Least times in
   cycles. told, kept: how long the master's bits are valid before and after the sampling edge. */
typedef struct {
    uint64_t setup, high, low, period, hold, idle, told, kept;  /* master */
    uint64_t output, enable;                    /* slave: delay of a bit after its edge */
} hw_spi_timing;

/* The checked times of the master. */
enum {
    HW_SPI_SETUP = 0, HW_SPI_HIGH, HW_SPI_LOW, HW_SPI_PERIOD, HW_SPI_READ, HW_SPI_HOLD,
    HW_SPI_IDLE, HW_SPI_TOLD, HW_SPI_KEPT, HW_SPI_CHECKS
};

typedef struct hw_spi hw_spi;
typedef struct { int select, clock, data, input; } hw_spi_pins;  /* input -1: it only sends */
hw_spi *hw_spi_new(hw *h, hw_spi_pins pins, void *handle, const hw_spi_timing *timing);
void hw_spi_retime(hw_spi *s, const hw_spi_timing *timing);
void hw_spi_connect(hw_spi *s, int connected);
void hw_spi_load(hw_spi *s, const uint8_t *word, int bits);  /* 16 bytes, highest bit first */
/* Copies the whole bytes received since select, 17 at most, and returns their number. */
int hw_spi_told(hw_spi *s, uint8_t *into);
const hw_check *hw_spi_checks(hw_spi *s);   /* HW_SPI_CHECKS of them */

/* A relay: the pin and the active level of its coil, the pin of its mirror contact or -1; delays of
   its contacts in cycles. */
enum { HW_RELAY_SOUND = 0, HW_RELAY_WELDED = 1, HW_RELAY_DEAD = 2 };
enum { HW_WIRE_SOUND = 0, HW_WIRE_TORN = 1, HW_WIRE_SHORTED = 2 };
typedef struct hw_relay hw_relay;
hw_relay *hw_relay_new(hw *h, int coil, int active_high, int contact, uint64_t operate,
                       uint64_t release);
void hw_relay_fail(hw_relay *r, int state, int wire);
int hw_relay_closed(hw_relay *r);               /* the main contacts */
uint64_t hw_relay_closed_cycles(hw_relay *r);

/* A fan: the pin and the active level of its motor, the pin of its tachometer's open collector;
   pulses per cycle at full speed, time constant in cycles. pace: share of full speed; noise: other
   pulses per cycle on the line, or 0; low: share of a pulse that is low, above 0 and below 1. */
typedef struct hw_fan hw_fan;
hw_fan *hw_fan_new(hw *h, int motor, int active_high, int line, double full, double lag);
void hw_fan_fail(hw_fan *f, double pace, double noise, double low, int wire);
double hw_fan_speed(hw_fan *f);                 /* pulses per cycle */

/* A tip's present and past temperatures: C sets them, the chip reads them for a conversion. A value
   that does not change is stored once. */
enum { HW_TIP_KEEPS = 4096 };
typedef struct {
    uint64_t since[HW_TIP_KEEPS], told_at;
    double felt[HW_TIP_KEEPS];
    uint32_t newest, older;     /* index of the newest, and number of older ones */
} hw_tip;
void hw_tip_tell(hw_tip *t, uint64_t cycle, double felt);
double hw_tip_felt(const hw_tip *t, uint64_t cycle);  /* at a cycle, or the oldest stored */

/* A machine: see machine.c. Python owns all arrays. Indices are of states, loads, ADC channels. */
enum { HW_SENSES = 0, HW_RUNS = 1, HW_HEATS = 2 };  /* phases of a step */
enum { HW_MACHINE_PLACES = 4096 };                  /* a power of two, over twice the matrices */
typedef struct { int load; double power_w; } hw_heater;
typedef struct { int here, there; double factor; } hw_surface;
typedef struct {
    int state, channel;         /* channel -1: set the tip or, without one, call Python */
    hw_tip *tip;
    double older;               /* weight of the older of two steps */
    double *past;               /* a ring buffer */
    int length, oldest;
    const double *noise;        /* drawn in advance, used from the end; NULL: none */
    int drawn;
    double error;               /* constant error */
} hw_feeler;
typedef struct { int load, channel; double full_a, share; } hw_meter;
typedef struct {
    int pin, active_high, behind_relay, beside_of;
    uint64_t high;
    double times, least, once_asked;    /* faults between pin and load; once_asked -1: none */
    double volts, taken;                /* share of the nominal supply; share of power taken away */
    double beside, below;               /* another heat source, while the sensor is below this */
} hw_load;
typedef struct { uint16_t address, size; uint8_t was[8]; } hw_variable;
/* See Look in Python. */
typedef struct { uint64_t at, every, latest; int drifts, uart; uint64_t silence; } hw_look;
typedef struct {
    hw *h;
    void *handle;
    hw_relay *relay;
    double clock_hz, step_s, powered_s, began_s;
    uint64_t row, until, read_at, relay_closed, left;
    hw_look look;
    int phase;
    /* the network */
    int states, nodes, inputs, heater_count, surface_count, fan_count;
    const hw_heater *heaters;
    const hw_surface *surfaces;
    const int *fans;
    double zero_c_k, log_grid, feed;
    double *vector, *next, *key, *keys, *matrices;
    int key_size;
    uint32_t matrices_known, matrices_room, places[HW_MACHINE_PLACES];
    /* its sensors and its loads */
    int feeler_count, meter_count, load_count, steps_motors;
    hw_feeler *feelers;
    const hw_meter *meters;
    hw_load *loads;
    double *felt, *tips;        /* values of the feelers, then of the meters */
    int feels;                  /* a tip has a fault: Python sets its temperature */
    double *active, *given, *conducts, closed;
    /* stop conditions: a variable changes, a feeler is below a limit, no node exceeds its `highest`
       without heat, the level of a load's pin changes; below_of, turns -1: no such condition */
    hw_variable *looked_at;
    int looked_at_count, below_of, until_spread, turns, turned_from;
    double below;
    /* results */
    double *highest, peak;
    int peak_of, watches, spreads, sensed, logs_nodes;
    double *log;
    size_t logged, log_room, columns;
} hw_machine;
void hw_machine_matrix(hw_machine *m, const double *matrix);  /* adds the present key's matrix */
void hw_machine_begin(hw_machine *m);   /* one step by hand: set the tips, */
void hw_machine_read(hw_machine *m);    /* after the run read the switches, */
void hw_machine_supply(hw_machine *m);  /* compute the loads' powers, */
int hw_machine_heat(hw_machine *m);     /* and step the plant; or HW_MATRIX */
int hw_machine_go(hw_machine *m, uint64_t wake, uint64_t fed);
/* Run to a cycle, or until a part outside has to act: HW_NEWS, HW_WAKE. */
int hw_run_looking(hw *h, hw_look *look, uint64_t wake, uint64_t until);

/* Profile: see profile.c. function_of_word: the function's number for each flash word. */
int hw_profile_start(hw *h, const uint16_t *function_of_word, const uint32_t *starts,
                     int functions);
void hw_profile_stop(hw *h);
void hw_profile_trace_entry(hw *h, int function, int on);
typedef struct { uint64_t calls, total, longest, own, masked; } hw_function;
const hw_function *hw_profile_functions(hw *h);
const uint8_t *hw_profile_coverage(hw *h);
typedef struct {
    uint64_t cycles, at;
    uint32_t pc;
} hw_stretch;
hw_stretch hw_profile_masked(hw *h);    /* longest with interrupts off, after the first enable */
hw_stretch hw_profile_busy(hw *h);      /* longest time in 8 words without sleep */
uint16_t hw_profile_stack(hw *h);       /* lowest stack pointer */
