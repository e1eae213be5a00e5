/* Relays: a coil on a pin, main contacts, and a mirror contact to ground on another pin.

   The contacts follow the coil after a delay. The mirror contact is closed while the main contacts
   are open, and never together with them, even if welded: IEC 60947-4-1, annex F. */
#include "peripherals/pins.h"

struct hw_relay {
    hw *h;
    int coil, active_high, contact;
    uint64_t operate, release;  /* from coil to contacts, cycles */
    int driven;                 /* the coil has current */
    int state, wire;            /* HW_RELAY_*, HW_WIRE_* */
    int closed;                 /* the main contacts conduct */
    int grounded;               /* the mirror contact's pin is at ground */
    uint64_t since, closed_cycles;
    struct timer *moves;
};

static void account(hw_relay *r) {
    uint64_t now = r->h->avr->cycle;
    if (r->closed)
        r->closed_cycles += now - r->since;
    r->since = now;
}

/* Set the level of the mirror contact's pin. */
static void show(hw_relay *r) {
    int grounded = r->wire == HW_WIRE_SHORTED || (r->wire == HW_WIRE_SOUND && !r->closed);
    if (r->contact < 0 || grounded == r->grounded)
        return;
    r->grounded = grounded;
    pin_hold(r->h, r->contact, 0, grounded);
}

static void move(hw_relay *r, int closed) {
    if (closed != r->closed) {
        account(r);
        r->closed = closed;
    }
    show(r);
}

/* The position of the contacts, by the coil and the faults. */
static int drawn(const hw_relay *r) {
    return r->state == HW_RELAY_WELDED || (r->state == HW_RELAY_SOUND && r->driven);
}

static void on_move(hw *h, void *param, uint64_t when) {
    hw_relay *r = param;
    (void)h, (void)when;
    move(r, drawn(r));
}

/* The level of the coil's pin has changed. */
static void on_coil(void *param, int high) {
    hw_relay *r = param;
    r->driven = high == r->active_high;
    if (drawn(r) != r->closed)
        timer_set(r->moves, r->h->avr->cycle + (drawn(r) ? r->operate : r->release));
    else
        timer_stop(r->moves);
}

hw_relay *hw_relay_new(hw *h, int coil, int active_high, int contact, uint64_t operate,
                       uint64_t release) {
    hw_relay *r = hw_pin_watch(h, coil, 1) || (contact >= 0 && hw_pin_watch(h, contact, 0))
        ? NULL : chip_new(h, &h->relay_count, HW_RELAYS, sizeof *r);
    if (!r)
        return NULL;
    *r = (hw_relay){.h = h, .coil = coil, .active_high = active_high, .contact = contact,
                    .operate = operate, .release = release, .since = h->avr->cycle};
    r->moves = timer_new(h, on_move, r);
    show(r);
    pin_follow(h, coil, (struct pin_follower){on_coil, r});
    return r;
}

void hw_relay_fail(hw_relay *r, int state, int wire) {
    r->state = state;
    r->wire = wire;
    timer_stop(r->moves);
    move(r, drawn(r));
}

int hw_relay_closed(hw_relay *r) { return r->closed; }

uint64_t hw_relay_closed_cycles(hw_relay *r) {
    account(r);
    return r->closed_cycles;
}
