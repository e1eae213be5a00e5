/* The shim's internal structures. */
#ifndef HEATWRIGHT_HW_H
#define HEATWRIGHT_HW_H

#include <stddef.h>
#include <stdint.h>
#include <simavr/avr_adc.h>
#include <simavr/avr_eeprom.h>
#include <simavr/avr_extint.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_timer.h>
#include <simavr/avr_uart.h>
#include <simavr/avr_watchdog.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_core.h>
#include "api.h"

#define HW_PORTS 12             /* A to L */
#define HW_PINS (8 * HW_PORTS)
#define HW_UARTS 4
#define HW_CHANNELS 16
#define HW_SNAPSHOTS 8
#define HW_WIRES 8              /* 1-Wire slaves */
#define HW_SPIS 8               /* SPI slaves */
#define HW_RELAYS 4
#define HW_FANS 4
#define HW_TIMERS 40
#define HW_LOG_FULL (1u << 20)  /* size of a log, bytes, at which hw_run returns to have it emptied */

/* Implemented in Python, see callbacks.h. */
void hw_onewire_received(void *handle, int first, const uint8_t *data, int bits, uint64_t cycle);
void hw_spi_selected(void *handle, uint64_t cycle);
void hw_spi_released(void *handle, uint64_t cycle);
void hw_spi_addressed(void *handle, uint8_t address, uint64_t cycle);
void hw_machine_sense(void *handle, int sensor, double felt);
double hw_machine_fed(void *handle);
void hw_machine_feel(void *handle);

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

/* A function of the shim that runs after simavr's own handler of a register. */
struct tap {
    avr_io_write_t write;
    void *write_param;
    avr_io_read_t read;
    void *read_param;
};
typedef void (*tapped_fn)(hw *h, void *param);
void tap_write(hw *h, avr_io_addr_t address, avr_io_write_t ours, void *param, struct tap *tap);
void tap_read(hw *h, avr_io_addr_t address, avr_io_read_t ours, void *param, struct tap *tap);

struct wire_listener {
    void (*edge)(void *param, int low, uint64_t cycle);
    void (*sampled)(void *param, uint64_t cycle);
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
    hw_relay *relay;            /* the relay whose coil it drives */
    hw_fan *fan;                /* the fan whose motor it drives */
    struct wire_listener listeners[HW_WIRES];
    int listener_count;
};

struct port {
    hw *h;
    int index;
    avr_ioport_t *io;           /* NULL: this part has no such port */
    uint8_t watched;            /* bits */
    uint8_t sampled;            /* bits whose reads are checked */
    uint8_t ddr, port;          /* as last seen */
    struct tap tap_pin;
};

/* A character to a UART: its bits, the start bit first, and its time. */
struct character {
    double start, bit;          /* cycles */
    uint16_t levels;
    uint8_t bits;
};
struct line {
    struct character *queue;
    size_t first, count;
    double free;                /* the cycle from which the next may be sent */
};

#define RECEIVED 3              /* two in the buffer, and one in the shift register */
struct received {
    uint16_t value;
    uint8_t framing, parity;    /* errors */
};
struct receiver {
    int on, count, overrun;
    struct received buffer[RECEIVED];
    double from, first;         /* searches a start bit since; its first low sample */
    int samples, period, data, parity;  /* of the arriving character */
    struct timer *timer;
};

struct uart {
    hw *h;
    int index;
    avr_uart_t *io;
    uint8_t format, divisor_high;       /* UCSRC, UBRRH */
    uint64_t shared_read;               /* the cycle of their last read if they share an address */
    uint64_t begins, ends, overruns;    /* of the last character sent */
    struct timer *buffer_free, *all_sent;
    struct line line;
    struct receiver receiver;
};

/* One compare output of a timer, on its pin. */
struct compare {
    hw *h;
    avr_timer_t *timer;
    int channel, pin;
    struct compare *next;
    struct tap taps[5];
};

struct snapshot {
    uint16_t counter, base, size;
    uint8_t counter_size;
    uint32_t last;
};

/* Millivolts at equal distances of the sensor's value. */
struct curve {
    const double *millivolts;   /* NULL: none */
    size_t count;
    double first, per_unit, felt;
};

struct profile;
struct fast;

struct hw {
    avr_t *avr;
    char message[256];
    int limit;
    uint64_t sleep_cycles, until;       /* in hw_run: its end cycle */
    int dead_sleep;             /* asleep with interrupts off */
    uint16_t sleep_register;
    uint8_t sleep_enable, sleep_mode;
    int entry_cycles;
    struct fast *fast;
    int reference;              /* use simavr's core, not ours */
    struct timer *stop;
    struct timer timers[HW_TIMERS];
    int timer_count;
    struct log logs[HW_LOGS];
    int log_full;

    struct port ports[HW_PORTS];
    struct pin pins[HW_PINS];
    struct compare *compares;
    struct uart uarts[HW_UARTS];

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
    hw_onewire *wires[HW_WIRES];
    int wire_count;
    hw_spi *spis[HW_SPIS];
    int spi_count;
    hw_relay *relays[HW_RELAYS];
    int relay_count;
    hw_fan *fans[HW_FANS];
    int fan_count;
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

avr_io_t *io_find(hw *h, const char *kind, int nth);
void limit(hw *h, const char *format, ...);
void crash(hw *h, const char *why);

/* The peripherals: set up once, and corrected after every reset. */
int pins_init(hw *h);
void pins_reset(hw *h);
void pin_update(hw *h, int pin);
void pin_hold(hw *h, int pin, int high, int held);
int pin_listen(hw *h, int pin, struct wire_listener listener);
void compare_init(hw *h);
void compare_reset(hw *h);
void compare_watch(hw *h, int pin);
void uart_init(hw *h);
void uart_reset(hw *h);
void uart_free(hw *h);
void adc_init(hw *h);
void eeprom_init(hw *h);
void eeprom_reset(hw *h);
void watchdog_init(hw *h);
void old_reset(hw *h);
void snapshots_take(hw *h);
void snapshots_reset(hw *h);
void onewire_free(hw *h);
void spi_free(hw *h);
void relay_coil(hw_relay *r, int high);
void relay_free(hw *h);
void fan_driven(hw_fan *f, int high);
void fan_free(hw *h);
#define BURST 100000            /* cycles without a check of the wall clock: under 1 ms */
void fast_init(hw *h);
void fast_free(hw *h);
void fast_forget(hw *h);
avr_flashaddr_t fast_run(hw *h);
avr_flashaddr_t profiled_run(hw *h);
void profile_free(hw *h);
int profile_settled(hw *h);
void profile_before(hw *h);
void profile_after(hw *h, uint32_t pc);   /* pc: of the next instruction */
void profile_interrupt(hw *h);
void profile_sleep(hw *h);
void profile_slept(hw *h, uint64_t cycles);
void profile_reset(hw *h);

#endif
