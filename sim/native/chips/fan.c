/* A fan with a tachometer: a motor that follows its line with a time constant, and an open collector
   that pulses to ground on another pin. Its speed between events is an exact exponential. */
#include <math.h>
#include "peripherals/pins.h"

#define TRIES 40                /* most Newton iterations; three or four are usual */
#define NEAR 0.25               /* cycles */

struct hw_fan {
    hw *h;
    int line, active_high;
    double full, lag;           /* pulses per cycle, cycles */
    int driven, wire;
    double pace, noise, low;    /* share of `full`; other pulses per cycle; share at ground */
    double speed, phase;        /* pulses per cycle, 0..1 of a pulse, both at `since` */
    uint64_t since;
    int grounded;
    struct timer *edge;
};

static double target(const struct hw_fan *f) { return f->driven ? f->full * f->pace : 0.0; }

/* Pulses in the next x cycles. */
static double pulses(const struct hw_fan *f, double x) {
    if (f->noise > 0.0)
        return f->noise * x;
    return target(f) * x + (f->speed - target(f)) * f->lag * -expm1(-x / f->lag);
}

static double speed_after(const struct hw_fan *f, double x) {
    return target(f) + (f->speed - target(f)) * exp(-x / f->lag);
}

static void advance(struct hw_fan *f, uint64_t now) {
    double x = (double)(now - f->since);
    f->phase += pulses(f, x);
    f->speed = speed_after(f, x);
    f->since = now;
    if (f->phase >= 1.0)
        f->phase -= floor(f->phase);
}

static void show(struct hw_fan *f) {
    int grounded = f->wire == HW_WIRE_SHORTED || (f->wire == HW_WIRE_SOUND && f->phase < f->low);
    if (grounded == f->grounded)
        return;
    f->grounded = grounded;
    pin_hold(f->h, f->line, 0, grounded);
}

/* Cycles until this share of a pulse is reached; negative: never. Newton's method starts on the side
   from which it does not overshoot: above while the fan accelerates, below while it slows down. */
static double until(const struct hw_fan *f, double part) {
    double to = target(f);
    if (f->noise > 0.0)
        return part / f->noise;
    if (to <= 0.0 && f->speed * f->lag <= part * (1.0 + 1e-9))
        return -1.0;
    double x = to > f->speed ? part / to + f->lag : part / f->speed;
    for (int n = 0; n < TRIES; n++) {
        double step = (part - pulses(f, x)) / speed_after(f, x);
        x += step;
        if (fabs(step) < NEAR)
            break;
    }
    return x;
}

static void wait_for_edge(struct hw_fan *f) {
    double x = until(f, (f->phase < f->low ? f->low : 1.0) - f->phase);
    if (x < 0.0)
        timer_stop(f->edge);
    else
        timer_set(f->edge, f->since + (uint64_t)(x < 1.0 ? 1.0 : ceil(x)));
}

static void on_edge(hw *h, void *param, uint64_t when) {
    struct hw_fan *f = param;
    (void)h;
    advance(f, when);
    show(f);
    wait_for_edge(f);
}

/* The level of the motor's pin has changed. */
static void on_motor(void *param, int high) {
    hw_fan *f = param;
    advance(f, f->h->avr->cycle);
    f->driven = high == f->active_high;
    wait_for_edge(f);
}

hw_fan *hw_fan_new(hw *h, int motor, int active_high, int line, double full, double lag) {
    hw_fan *f = hw_pin_watch(h, motor, 1) || hw_pin_watch(h, line, 0)
        ? NULL : chip_new(h, &h->fan_count, HW_FANS, sizeof *f);
    if (!f)
        return NULL;
    *f = (hw_fan){.h = h, .line = line, .active_high = active_high, .full = full, .lag = lag,
                  .low = 0.5, .pace = 1.0, .since = h->avr->cycle};
    f->edge = timer_new(h, on_edge, f);
    show(f);
    pin_follow(h, motor, (struct pin_follower){on_motor, f});
    return f;
}

void hw_fan_fail(hw_fan *f, double pace, double noise, double low, int wire) {
    advance(f, f->h->avr->cycle);
    f->pace = pace;
    f->noise = noise;
    f->low = low;
    f->wire = wire;
    if (f->speed > f->full * pace)
        f->speed = f->full * pace;      /* a rotor that is blocked stops at once */
    show(f);
    wait_for_edge(f);
}

double hw_fan_speed(hw_fan *f) {
    advance(f, f->h->avr->cycle);
    return f->speed;
}
