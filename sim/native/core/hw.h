/* One processor in the shim, and the tools of all its parts: logs, timers, taps, limits. */
#pragma once

#include <stddef.h>
#include <stdint.h>
#include <simavr/avr_adc.h>
#include <simavr/avr_eeprom.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_watchdog.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_core.h>
#include "api.h"

#define HW_PORTS 12             /* A to L */
#define HW_PINS (8 * HW_PORTS)
#define HW_CHANNELS 16
#define HW_SNAPSHOTS 8
#define HW_WIRES 8              /* 1-Wire slaves */
#define HW_SPIS 8               /* SPI slaves */
#define HW_RELAYS 4
#define HW_FANS 4
#define HW_FOLLOWERS (HW_RELAYS + HW_FANS)
#define HW_TIMERS 40
#define HW_LOG_FULL (1u << 20)  /* size of a log, bytes, at which hw_run returns to have it emptied */

/* A growing array of records. */
struct log {
    uint8_t *data;
    size_t size, capacity, record;
};
void *log_add(hw *h, int log);

/* A callback at a cycle; unlike simavr's timers it survives a reset of the processor. */
typedef void (*timer_fn)(hw *h, void *param, uint64_t when);
struct timer {
    hw *h;
    timer_fn fire;
    void *param;
    uint64_t due;
    int armed;
};
struct timer *timer_new(hw *h, timer_fn fire, void *param);
void timer_set(struct timer *t, uint64_t due);
void timer_stop(struct timer *t);

/* simavr's own handlers of a register, which functions of the shim replace and may call. */
struct tap {
    avr_io_write_t write;
    void *write_param;
    avr_io_read_t read;
    void *read_param;
};
void tap_write(hw *h, avr_io_addr_t address, avr_io_write_t ours, void *param, struct tap *tap);
void tap_read(hw *h, avr_io_addr_t address, avr_io_read_t ours, void *param, struct tap *tap);

struct wire_listener {
    void (*edge)(void *param, int low, uint64_t cycle);
    void (*sampled)(void *param, uint64_t cycle);
    void *param;
};

/* A coil or a motor on a pin, which is told the pin's level at each change. */
struct pin_follower {
    void (*level)(void *param, int high);
    void *param;
};

struct pin {
    uint8_t watched, logged;
    uint8_t drive, pull;        /* HW_NONE, HW_LOW, HW_HIGH from outside */
    uint8_t held[2];            /* number of chips that hold it low, and high */
    uint8_t state;              /* level | source << 1 */
    uint8_t line_low;           /* held low by anything but a chip */
    uint8_t compare, compare_level;     /* a timer's output drives the pin */
    uint8_t contention;
    uint64_t since, high_cycles, contention_cycles, rises;
    struct pin_follower followers[HW_FOLLOWERS];
    int follower_count;
    struct wire_listener listeners[HW_WIRES];
    int listener_count;
};

struct port {
    hw *h;
    int index;
    avr_ioport_t *io;           /* NULL: this part has no such port */
    uint8_t watched;            /* bits */
    uint8_t sampled;            /* bits with listeners, which are told of reads */
    uint8_t ddr, port;          /* their values at the last look */
    struct tap tap_pin;
};

struct snapshot {
    uint16_t counter, base, size;
    uint8_t counter_size;
    uint32_t at, last;          /* at: address of the code before which it is taken, or HW_AT_SLEEP */
};

/* Millivolts at equal distances of the sensor's value. */
struct curve {
    const double *millivolts;   /* NULL: none */
    size_t count;
    double first, per_unit, felt;
};

struct compare;
struct uart;
struct profile;
struct fast;

struct hw {
    avr_t *avr;
    char message[256];
    int limit;
    uint64_t sleep_cycles;
    uint64_t until;             /* the cycle at which hw_run ends */
    int dead_sleep;             /* asleep with interrupts off */
    uint16_t sleep_register;
    uint8_t sleep_enable, sleep_mode;
    int entry_cycles;
    struct fast *fast;
    int reference;              /* use simavr's core, not ours */
    uint32_t mark;              /* snapshots are taken before the instruction here */
    struct timer *stop;
    struct timer timers[HW_TIMERS];
    int timer_count;
    struct log logs[HW_LOGS];
    int log_full;

    struct port ports[HW_PORTS];
    struct pin pins[HW_PINS];
    struct compare *compares;
    void (*watch_compares)(hw *h, int pin);  /* called when a pin begins to be watched */
    struct uart *uarts;         /* HW_UARTS of them */

    avr_adc_t *adc;
    struct tap tap_adcsra, tap_adcl, tap_adch;
    double channels[HW_CHANNELS], aref_mv, avcc_mv;
    struct curve curves[HW_CHANNELS];
    uint16_t adc_pending, adc_result;
    int adc_locked, adc_hung, adc_stuck;
    uint16_t adc_codes[HW_CHANNELS];    /* last code of each channel */
    uint8_t adc_mux5;           /* its bit in ADCSRB; 0: no channels 8 to 15 */
    uint8_t adc_known;          /* ADMUX code of the band gap */
    double known_mv;
    uint64_t adc_conversions;

    avr_eeprom_t *eeprom;
    struct tap tap_eecr;
    struct timer *eeprom_timer;
    double eeprom_seconds;
    int eeprom_busy;
    uint16_t eeprom_address;
    uint8_t eeprom_old, eeprom_new;
    uint64_t eeprom_writes, eeprom_violations;

    avr_watchdog_t *watchdog;
    struct tap tap_wdtcsr;
    int old;                    /* an ATmega16 or 32 */

    struct snapshot snapshots[HW_SNAPSHOTS];
    int snapshot_count;
    void *chips[HW_WIRES + HW_SPIS + HW_RELAYS + HW_FANS];
    int chip_count, wire_count, spi_count, relay_count, fan_count;
    struct profile *profile;
};

/* As avr_raise_irq, but without the call if no hook is registered. */
static inline void raise_irq(avr_irq_t *irq, uint32_t value) {
    if (irq->flags & IRQ_FLAG_NOT) {
        avr_raise_irq(irq, value);
    } else if (!irq->hook) {
        irq->flags &= (uint8_t)~IRQ_FLAG_INIT;
        irq->value = value;
    } else if (irq->value != value || !(irq->flags & IRQ_FLAG_FILTERED) ||
               irq->flags & IRQ_FLAG_INIT) {
        avr_raise_irq(irq, value);
    }
}

/* Raise the IRQs of a register, if any: one for each bit, and one for the whole register. */
static inline void raise_register(avr_t *avr, avr_io_addr_t address, uint8_t value) {
    avr_irq_t *irq = avr->io[AVR_DATA_TO_IO(address)].irq;
    if (!irq)
        return;
    raise_irq(irq + AVR_IOMEM_IRQ_ALL, value);
    for (int bit = 0; bit < 8; bit++)
        raise_irq(irq + bit, value >> bit & 1);
}

/* Write a register with handlers as simavr does. */
static inline void write_register(avr_t *avr, uint16_t address, uint8_t value) {
    const avr_io_addr_t a = AVR_DATA_TO_IO(address);
    if (avr->io[a].w.c)
        avr->io[a].w.c(avr, address, value, avr->io[a].w.param);
    else
        avr->data[address] = value;
    raise_register(avr, address, value);
}

/* As avr_cycle_timer_process, but without the call if no timer is due; returns the cycles to the
   next timer. */
static inline avr_cycle_count_t pass_timers(avr_t *avr) {
    const avr_cycle_timer_slot_p next = avr->cycle_timers.timer;
    if (!next || next->when <= avr->cycle)
        return avr_cycle_timer_process(avr);
    avr_cycle_count_t idle = next->when - avr->cycle;
    avr->run_cycle_count = idle < avr->run_cycle_limit ? idle : avr->run_cycle_limit;
    return idle;
}

/* Whether an interrupt waits. */
static inline int waiting(const avr_t *avr) {
    return avr->interrupts.pending.read != avr->interrupts.pending.write;
}

void *chip_new(hw *h, int *count, int most, size_t size);
void checks_start(hw_check *checks, int count);
void check_add(hw_check *check, uint64_t cycles, int wrong);
avr_io_t *io_find(hw *h, const char *kind, int nth);
void limit(hw *h, const char *format, ...);
void crash(hw *h, const char *why);
void snapshots_take(hw *h, uint32_t at);
void snapshots_reset(hw *h);
