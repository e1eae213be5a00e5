/* Differences of the ATmega16 and 32 from later parts that simavr does not know.

   Timer 0 has the modes of timer 2; in simavr it has only the normal mode. Timer 2 can divide the
   clock by 32; simavr divides by 16. All timers share TIFR; simavr clears the flags of the others
   together with one. The watchdog's oscillator runs at 1 MHz; its timeout is not locked; after its
   reset it is off. */
#include <simavr/avr_timer.h>
#include "parts.h"

#define WGM0 6
#define WGM1 3
#define DIVIDED_BY_32 3         /* clock select of timer 2 */
#define WATCHDOG_HZ 1000000
#define WATCHDOG_CYCLES 16384   /* cycles of the shortest timeout */

static void give_modes(avr_timer_t *t) {
    t->wgm[0] = (avr_regbit_t)AVR_IO_REGBIT(t->cs[0].reg, WGM0);
    t->wgm[1] = (avr_regbit_t)AVR_IO_REGBIT(t->cs[0].reg, WGM1);
    t->wgm_op[2] = (avr_timer_wgm_t)AVR_TIMER_WGM_CTC();
    t->wgm_op[3] = (avr_timer_wgm_t)AVR_TIMER_WGM_FASTPWM8();
}

static void complete_timers(hw *h) {
    avr_timer_t *t;
    for (int nth = 0; (t = (avr_timer_t *)io_find(h, "timer", nth)); nth++)
        if (t->name == '0')
            give_modes(t);
        else if (t->name == '2')
            t->cs_div[DIVIDED_BY_32] = 5;
}

static void clear_if(hw *h, avr_int_vector_t *vector, uint8_t written) {
    if (vector->raised.reg && (written >> vector->raised.bit & 1))
        avr_clear_interrupt(h->avr, vector);
}

/* Writing a one clears a flag, a zero keeps it. */
static void on_flags(struct avr_t *avr, avr_io_addr_t address, uint8_t value, void *param) {
    hw *h = param;
    avr_timer_t *t;
    uint8_t left = avr->data[address] & (uint8_t)~value;
    for (int nth = 0; (t = (avr_timer_t *)io_find(h, "timer", nth)); nth++) {
        clear_if(h, &t->overflow, value);
        clear_if(h, &t->icr, value);
        for (int channel = 0; channel < AVR_TIMER_COMP_COUNT; channel++)
            clear_if(h, &t->comp[channel].interrupt, value);
    }
    avr->data[address] = left;
}

static void set_watchdog(hw *h, uint8_t value) {
    avr_watchdog_t *w = h->watchdog;
    avr_io_addr_t address = w->wdce.reg;
    uint8_t causes = h->avr->data[w->wdrf.reg];
    uint8_t opened = (uint8_t)(1u << w->wdce.bit | 1u << w->wde.bit);
    avr_regbit_clear(h->avr, w->wdrf);          /* simavr keeps the watchdog on while WDRF is set */
    h->tap_wdtcsr.write(h->avr, address, opened, h->tap_wdtcsr.write_param);
    h->tap_wdtcsr.write(h->avr, address, value, h->tap_wdtcsr.write_param);
    h->avr->data[w->wdrf.reg] = causes;
}

/* The watchdog can be switched off only within four cycles after WDTOE was set. */
static void on_watchdog(struct avr_t *avr, avr_io_addr_t address, uint8_t value, void *param) {
    hw *h = param;
    avr_watchdog_t *w = h->watchdog;
    int on = avr_regbit_get(avr, w->wde), opened = avr_regbit_get(avr, w->wdce);
    uint8_t enable = (uint8_t)(1u << w->wde.bit), changed = avr->data[address] ^ value;
    if (on && !opened)
        value |= enable;
    set_watchdog(h, value & (uint8_t)((1u << (w->wdce.bit + 1)) - 1));
    if (!(value & enable))
        return;
    uint64_t cycles = (uint64_t)WATCHDOG_CYCLES << avr_regbit_get_array(avr, w->wdp, 3);
    w->cycle_count = (avr_cycle_count_t)(cycles * avr->frequency / WATCHDOG_HZ);
    if (!on || (changed & (enable - 1)))
        avr_ioctl(avr, AVR_IOCTL_WATCHDOG_RESET, NULL);
}

void old_reset(hw *h) {
    if (h->old)
        set_watchdog(h, 0);
}

void hw_old_part(hw *h) {
    avr_timer_t *timer = (avr_timer_t *)io_find(h, "timer", 0);
    struct tap replaced;
    h->old = 1;
    complete_timers(h);
    tap_write(h, timer->overflow.raised.reg, on_flags, h, &replaced);
    tap_write(h, h->watchdog->wdce.reg, on_watchdog, h, &replaced);
}
