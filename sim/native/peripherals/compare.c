/* Timer outputs: the pins that timers drive, with the cases that simavr gets wrong.

   A pin driven by a timer no longer follows PORT. Fast PWM with a compare value of TOP or above is
   constant; simavr inverts it at TOP and ignores it above. With ICR as TOP, simavr reads compare
   value and TOP only when the timer is set up; here they apply from the next period, as on the chip.
   Phase-correct PWM has no edges in simavr: the run ends with a message. */
#include <stdlib.h>
#include <simavr/avr_timer.h>
#include "parts.h"
#include "pins.h"

/* One compare output of a timer, on its pin. */
struct compare {
    hw *h;
    avr_timer_t *timer;
    int channel, pin;
    struct compare *next;
    struct tap taps[5];
};

static uint8_t mode(struct compare *c) {
    return avr_regbit_get(c->h->avr, c->timer->comp[c->channel].com);
}

static uint8_t waveform(struct compare *c) {
    return avr_regbit_get_array(c->h->avr, c->timer->wgm, 4);
}

/* simavr treats modes 14 and 15 of a 16-bit timer, and 7 of an 8-bit one, as plain PWM. */
static int fast(struct compare *c) {
    if (c->timer->mode.kind == avr_timer_wgm_fast_pwm)
        return 1;
    return c->timer->mode.kind == avr_timer_wgm_pwm &&
           (c->timer->wgm[3].reg ? waveform(c) >= 14 : 1);
}

static int simulated(struct compare *c) {
    return fast(c) || c->timer->mode.kind == avr_timer_wgm_normal ||
           c->timer->mode.kind == avr_timer_wgm_ctc;
}

static int constant(struct compare *c) {
    uint64_t match = c->timer->comp[c->channel].comp_cycles;
    return fast(c) && c->timer->tov_cycles && (!match || match >= c->timer->tov_cycles);
}

/* Compare value with ICR as TOP: simavr stores it, but does not use it. */
static void renew_match(struct compare *c) {
    avr_timer_comp_t *comp = &c->timer->comp[c->channel];
    uint32_t value = c->h->avr->data[comp->r_ocr] |
        (comp->r_ocrh ? (uint32_t)c->h->avr->data[comp->r_ocrh] << 8 : 0);
    if (fast(c) && c->timer->mode.top == avr_timer_wgm_reg_icr)
        comp->comp_cycles =
            value <= c->timer->tov_top ? (uint64_t)c->timer->cs_div_value * (value + 1) : 0;
}

/* TOP in ICR: setting the (unchanged) trace flags makes simavr set the timer up again. */
static void renew_top(struct compare *c) {
    avr_timer_t *t = c->timer;
    uint32_t top = c->h->avr->data[t->r_icr] | (uint32_t)c->h->avr->data[t->r_icrh] << 8;
    if (t->mode.top != avr_timer_wgm_reg_icr || !t->cs_div_value || top == t->tov_top)
        return;
    if (c->h->avr->cycle - t->tov_base >= (uint64_t)t->cs_div_value * (top + 1))
        limit(c->h, "TOP of timer %c set below its count", t->name);
    else
        avr_ioctl(c->h->avr, AVR_IOCTL_TIMER_SET_TRACE(t->name), &t->trace);
}

/* Whether a timer drives a pin. Two may share it (OC0A and OC1C of an ATmega2560); simavr's
   ATmega32U4 has an OC3B on the pin of OC3A, which the part does not have. */
static int taken(hw *h, int pin) {
    for (struct compare *c = h->compares; c; c = c->next)
        if (c->pin == pin && mode(c) != avr_timer_com_normal)
            return 1;
    return 0;
}

static void refresh(struct compare *c) {
    struct pin *pin = &c->h->pins[c->pin];
    int mine = mode(c) != avr_timer_com_normal;
    if (!pin->watched)
        return;
    pin->compare = (uint8_t)taken(c->h, c->pin);
    if (mine && c->timer->cs_div_value && !simulated(c))
        limit(c->h, "phase-correct PWM on timer %c: simavr does not simulate its edges", c->timer->name);
    if (mine && constant(c))
        pin->compare_level = mode(c) == avr_timer_com_clear;
    pin_update(c->h, c->pin);
}

/* Watch a pin from now on: a timer may already drive it. */
static void watch(hw *h, int pin) {
    for (struct compare *c = h->compares; c; c = c->next)
        if (c->pin == pin)
            refresh(c);
}

static void on_output(struct avr_irq_t *irq, uint32_t value, void *param) {
    struct compare *c = param;
    struct pin *pin = &c->h->pins[c->pin];
    (void)irq;
    if (!pin->watched)
        return;
    pin->compare_level = constant(c) ? mode(c) == avr_timer_com_clear : (value & 0xff) != 0;
    pin_update(c->h, c->pin);
}

/* Whether a timer in CTC mode already uses the value of this compare register. */
static int counts_so(const avr_timer_t *t, int channel) {
    const avr_timer_comp_t *comp = &t->comp[channel];
    uint32_t value = t->io.avr->data[comp->r_ocr] |
        (comp->r_ocrh ? (uint32_t)t->io.avr->data[comp->r_ocrh] << 8 : 0);
    return t->mode.kind == avr_timer_wgm_ctc && t->cs_div_value &&
           (channel || t->tov_top == value) &&
           comp->comp_cycles == (uint64_t)t->cs_div_value * (value + 1);
}

/* Whether a write only repeats a timer register's value (mode, clock, compare, pin), as firmware
   does to refresh it. */
static int renewed(struct compare *c, avr_io_addr_t a, uint8_t v) {
    const avr_timer_t *t = c->timer;
    if (v != c->h->avr->data[a] || a == t->r_icr)
        return 0;
    if (a == t->comp[0].r_ocr)
        return counts_so(t, 0);
    return a != t->comp[c->channel].r_ocr || counts_so(t, c->channel);
}

static void on_register(struct compare *c, struct tap *tap, avr_io_addr_t a, uint8_t v) {
    if (renewed(c, a, v))
        return;
    if (tap->write)
        tap->write(c->h->avr, a, v, tap->write_param);
    else
        c->h->avr->data[a] = v;
    if (a == c->timer->r_icr)
        renew_top(c);
    if (a == c->timer->comp[c->channel].r_ocr)
        renew_match(c);
    refresh(c);
}

#define REGISTER(n) \
    static void on_register_##n(struct avr_t *avr, avr_io_addr_t a, uint8_t v, void *param) { \
        struct compare *c = param; \
        (void)avr; \
        on_register(c, &c->taps[n], a, v); \
    }
REGISTER(0) REGISTER(1) REGISTER(2) REGISTER(3) REGISTER(4)

static int pin_of(hw *h, avr_regbit_t where) {
    for (int i = 0; i < HW_PORTS; i++)
        if (where.reg && h->ports[i].io && h->ports[i].io->r_port == where.reg)
            return 8 * i + where.bit;
    return -1;
}

static void tap_all(struct compare *c) {
    static const avr_io_write_t handlers[] = {on_register_0, on_register_1, on_register_2,
                                              on_register_3, on_register_4};
    avr_timer_t *t = c->timer;
    avr_io_addr_t registers[] = {t->comp[c->channel].com.reg, t->cs[0].reg,
                                 t->comp[c->channel].r_ocr, t->r_icr, t->comp[0].r_ocr};
    for (int i = 0; i < 5; i++) {
        int again = 0;
        for (int j = 0; j < i; j++)
            again |= registers[i] == registers[j];
        if (registers[i] && !again)
            tap_write(c->h, registers[i], handlers[i], c, &c->taps[i]);
    }
}

static void add(hw *h, avr_timer_t *timer, int channel) {
    int pin = pin_of(h, timer->comp[channel].com_pin);
    struct compare *c = pin < 0 ? NULL : calloc(1, sizeof *c);
    if (!c)
        return;
    *c = (struct compare){.h = h, .timer = timer, .channel = channel, .pin = pin,
                          .next = h->compares};
    h->compares = c;
    tap_all(c);
    avr_irq_register_notify(timer->io.irq + TIMER_IRQ_OUT_COMP + channel, on_output, c);
}

void compare_init(hw *h) {
    avr_timer_t *timer;
    h->watch_compares = watch;
    for (int nth = 0; (timer = (avr_timer_t *)io_find(h, "timer", nth)); nth++)
        for (int channel = 0; channel < AVR_TIMER_COMP_COUNT; channel++)
            add(h, timer, channel);
}

void compare_reset(hw *h) {
    for (struct compare *c = h->compares; c; c = c->next)
        h->pins[c->pin].compare = h->pins[c->pin].compare_level = 0;
}

void compare_free(hw *h) {
    for (struct compare *next; h->compares; h->compares = next) {
        next = h->compares->next;
        free(h->compares);
    }
}
