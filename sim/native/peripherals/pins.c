/* Pins: what drives them, their level, and how long it lasts.

   simavr's pin IRQs cannot be used: they are missing when a pin floats and at a reset, and wrong
   when a port is written while a timer drives a pin. So the level is computed here, after every
   write of PORT, DDR or PIN, and given to simavr so that the program can read it. */
#include "parts.h"
#include "pins.h"
#include "callbacks.h"

static int level_of(uint8_t drive) { return drive == HW_HIGH; }

/* The pin's level and its source: the strongest one that exists. */
static uint8_t resolve(struct port *p, struct pin *pin, int bit) {
    int output = p->ddr >> bit & 1, high = p->port >> bit & 1;
    if (pin->drive)
        return (uint8_t)(level_of(pin->drive) | HW_BY_OTHERS << 1);
    if (pin->held[0] || pin->held[1])
        return (uint8_t)((!pin->held[0]) | HW_BY_OTHERS << 1);
    if (output)
        return (uint8_t)((pin->compare ? pin->compare_level : high) | HW_BY_MCU << 1);
    if (pin->pull)
        return (uint8_t)(level_of(pin->pull) | HW_BY_RESISTOR << 1);
    if (high)
        return 1 | HW_BY_PULL_UP << 1;
    return (uint8_t)((pin->state & 1) | HW_FLOATING << 1);  /* keeps its last level */
}

/* Give the level to simavr for reads and pin interrupts, unless the program itself drives it. */
static void show(struct port *p, struct pin *pin, int bit) {
    avr_t *avr = p->h->avr;
    uint8_t mask = (uint8_t)(1 << bit);
    int source = pin->state >> 1, level = pin->state & 1;
    if (source == HW_BY_OTHERS || source == HW_BY_RESISTOR) {
        p->io->external.pull_mask |= mask;
        p->io->external.pull_value =
            (uint8_t)(level ? p->io->external.pull_value | mask
                            : p->io->external.pull_value & ~mask);
    } else {
        p->io->external.pull_mask &= (uint8_t)~mask;
        p->io->external.pull_value &= (uint8_t)~mask;
    }
    if (source == HW_BY_MCU)
        return;
    avr->data[p->io->r_pin] = (uint8_t)(level ? avr->data[p->io->r_pin] | mask
                                              : avr->data[p->io->r_pin] & ~mask);
    avr_raise_irq(p->io->io.irq + bit, (uint32_t)level);
}

static void account(struct pin *pin, uint64_t now) {
    if (pin->state & 1)
        pin->high_cycles += now - pin->since;
    if (pin->contention)
        pin->contention_cycles += now - pin->since;
    pin->since = now;
}

static void record(hw *h, int number, struct pin *pin) {
    hw_pin_event *e = log_add(h, HW_PIN_LOG);
    e->cycle = h->avr->cycle;
    e->pin = (uint8_t)number;
    e->state = pin->state;
}

/* Tell the chips on a pin about levels that do not come from the chip itself. */
static void tell(struct port *p, struct pin *pin, int bit) {
    int driven_low = (p->ddr >> bit & 1) && !(p->port >> bit & 1);
    uint8_t low = pin->drive ? pin->drive == HW_LOW : driven_low;
    if (low == pin->line_low)
        return;
    pin->line_low = low;
    for (int i = 0; i < pin->listener_count; i++)
        pin->listeners[i].edge(pin->listeners[i].param, low, p->h->avr->cycle);
}

static int contends(struct port *p, struct pin *pin, int bit) {
    int output = p->ddr >> bit & 1, high = p->port >> bit & 1;
    if (!output)
        return 0;
    return (pin->drive && level_of(pin->drive) != high) || pin->held[!high];
}

void pin_update(hw *h, int number) {
    struct port *p = &h->ports[number / 8];
    struct pin *pin = &h->pins[number];
    int bit = number % 8;
    uint8_t state = resolve(p, pin, bit);
    uint8_t contention = (uint8_t)contends(p, pin, bit);
    if (state != pin->state || contention != pin->contention) {
        account(pin, h->avr->cycle);
        int changed = state != pin->state;
        pin->rises += state & ~pin->state & 1;
        pin->state = state;
        pin->contention = contention;
        if (changed && pin->logged)
            record(h, number, pin);
        show(p, pin, bit);
        for (int i = 0; i < pin->follower_count; i++)
            pin->followers[i].level(pin->followers[i].param, state & 1);
    }
    tell(p, pin, bit);
}

static void port_refresh(struct port *p) {
    avr_t *avr = p->h->avr;
    uint8_t ddr = avr->data[p->io->r_ddr], port = avr->data[p->io->r_port];
    uint8_t changed = (uint8_t)(((ddr ^ p->ddr) | (port ^ p->port)) & p->watched);
    p->ddr = ddr;
    p->port = port;
    for (int bit = 0; changed; bit++, changed >>= 1)
        if (changed & 1)
            pin_update(p->h, 8 * p->index + bit);
}

/* As avr_ioport_update_irqs of simavr. */
static void raise_pins(struct port *p) {
    avr_t *avr = p->h->avr;
    avr_irq_t *irq = p->io->io.irq;
    uint8_t ddr = avr->data[p->io->r_ddr], port = avr->data[p->io->r_port];
    uint8_t pulled = p->io->external.pull_mask, pull = p->io->external.pull_value;
    uint8_t known = ddr | pulled | port;
    uint8_t level = (uint8_t)((port & (ddr | ~pulled)) | (pull & pulled & ~ddr));
    for (int bit = 0; bit < 8; bit++)
        if (known >> bit & 1)
            raise_irq(irq + bit, level >> bit & 1);
    uint8_t seen = (uint8_t)((avr->data[p->io->r_pin] & ~ddr) | (port & ddr));
    raise_irq(irq + IOPORT_IRQ_PIN_ALL, (uint8_t)((seen & ~pulled) | pull));
    raise_register(avr, p->io->r_port, port);
}

static void on_port(struct avr_t *avr, avr_io_addr_t a, uint8_t v, void *param) {
    struct port *p = param;
    avr->data[a] = v;
    raise_irq(p->io->io.irq + IOPORT_IRQ_REG_PORT, v);
    raise_pins(p);
    port_refresh(p);
}

static void on_ddr(struct avr_t *avr, avr_io_addr_t a, uint8_t v, void *param) {
    struct port *p = param;
    raise_irq(p->io->io.irq + IOPORT_IRQ_DIRECTION_ALL, v);
    avr->data[a] = v;
    raise_pins(p);
    port_refresh(p);
}

static void on_pin(struct avr_t *avr, avr_io_addr_t a, uint8_t v, void *param) {
    struct port *p = param;
    if (p->h->old)
        return;                 /* PIN is read-only on these parts */
    p->tap_pin.write(avr, a, v, p->tap_pin.write_param);
    port_refresh(p);
}

/* Correct reads of output pins: simavr ignores a stronger driver outside. */
static uint8_t levels(const struct port *p, uint8_t seen) {
    const struct pin *pin = &p->h->pins[8 * p->index];
    seen &= (uint8_t)~p->watched;
    for (unsigned watched = p->watched; watched; watched &= watched - 1) {
        int bit = __builtin_ctz(watched);
        seen |= (uint8_t)((pin[bit].state & 1) << bit);
    }
    return seen;
}

static uint8_t on_pin_read(struct avr_t *avr, avr_io_addr_t a, void *param) {
    struct port *p = param;
    for (unsigned sampled = p->sampled; sampled; sampled &= sampled - 1) {
        struct pin *pin = &p->h->pins[8 * p->index + __builtin_ctz(sampled)];
        for (int i = 0; i < pin->listener_count; i++)
            pin->listeners[i].sampled(pin->listeners[i].param, avr->cycle);
    }
    uint8_t seen = p->tap_pin.read(avr, a, p->tap_pin.read_param);
    return avr->data[a] = levels(p, seen);
}

int pins_init(hw *h) {
    for (int nth = 0;; nth++) {
        avr_ioport_t *io = (avr_ioport_t *)io_find(h, "port", nth);
        if (!io)
            return nth;
        int index = io->name - 'A';
        if (index < 0 || index >= HW_PORTS)
            continue;
        struct port *p = &h->ports[index];
        p->h = h;
        p->index = index;
        p->io = io;
        struct tap replaced;
        tap_write(h, io->r_port, on_port, p, &replaced);
        tap_write(h, io->r_ddr, on_ddr, p, &replaced);
        tap_write(h, io->r_pin, on_pin, p, &p->tap_pin);
        tap_read(h, io->r_pin, on_pin_read, p, &p->tap_pin);
    }
}

/* At a reset all pins of the processor float at once; drivers outside stay. */
void pins_reset(hw *h) {
    for (int i = 0; i < HW_PINS; i++) {
        struct port *p = &h->ports[i / 8];
        if (!p->io)
            continue;
        p->ddr = p->port = 0;
        if (!(p->watched >> (i % 8) & 1))
            continue;
        h->pins[i].compare = h->pins[i].compare_level = 0;
        pin_update(h, i);
        show(p, &h->pins[i], i % 8);
    }
}

int hw_pin_watch(hw *h, int pin, int logged) {
    struct port *p = pin >= 0 && pin < HW_PINS ? &h->ports[pin / 8] : NULL;
    if (!p || !p->io)
        return -1;
    h->pins[pin].logged |= (uint8_t)logged;
    if (h->pins[pin].watched)
        return 0;
    h->pins[pin].watched = 1;
    h->pins[pin].state = HW_FLOATING << 1;
    h->pins[pin].since = h->avr->cycle;
    p->watched |= (uint8_t)(1 << pin % 8);
    h->watch_compares(h, pin);
    pin_update(h, pin);
    return 0;
}

int hw_pin_drive(hw *h, int pin, int level) {
    if (hw_pin_watch(h, pin, 0))
        return -1;
    h->pins[pin].drive = (uint8_t)level;
    pin_update(h, pin);
    return 0;
}

int hw_pin_pull(hw *h, int pin, int level) {
    if (hw_pin_watch(h, pin, 0))
        return -1;
    h->pins[pin].pull = (uint8_t)level;
    pin_update(h, pin);
    return 0;
}

void pin_hold(hw *h, int pin, int high, int held) {
    h->pins[pin].held[high] = (uint8_t)(h->pins[pin].held[high] + (held ? 1 : -1));
    pin_update(h, pin);
}

int pin_listen(hw *h, int pin, struct wire_listener listener) {
    if (hw_pin_watch(h, pin, 0) || h->pins[pin].listener_count == HW_WIRES)
        return -1;
    struct port *p = &h->ports[pin / 8];
    h->pins[pin].listeners[h->pins[pin].listener_count++] = listener;
    p->sampled |= (uint8_t)(1 << pin % 8);
    return 0;
}

/* A chip whose bus only Python knows: it hears each edge. */
static void on_edge(void *param, int low, uint64_t now) { hw_pin_edge(param, low, now); }
static void on_sampled(void *param, uint64_t now) { (void)param, (void)now; }

int hw_pin_listen(hw *h, int pin, void *handle) {
    return pin_listen(h, pin, (struct wire_listener){on_edge, on_sampled, handle});
}

void hw_pin_hold(hw *h, int pin, int held) { pin_hold(h, pin, 0, held); }

void pin_follow(hw *h, int pin, struct pin_follower follower) {
    h->pins[pin].followers[h->pins[pin].follower_count++] = follower;
    follower.level(follower.param, h->pins[pin].state & 1);
}

int hw_pin_state(hw *h, int pin) { return h->pins[pin].state; }

uint64_t hw_pin_high_cycles(hw *h, int pin) {
    account(&h->pins[pin], h->avr->cycle);
    return h->pins[pin].high_cycles;
}

uint64_t hw_pin_rises(hw *h, int pin) { return h->pins[pin].rises; }

uint64_t hw_pin_contention_cycles(hw *h, int pin) {
    account(&h->pins[pin], h->avr->cycle);
    return h->pins[pin].contention_cycles;
}
