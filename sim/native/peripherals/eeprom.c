/* EEPROM: a write takes time, during which EEPE is set, and a power cut may interrupt it.

   simavr writes at once, and is ready 3.4 ms later on every part, so writes are kept from it.
   Here the cell also changes at once, but EEPE stays set for the part's programming time, and until
   then the byte counts as undefined (hw_eeprom_writing). */
#include <string.h>
#include "parts.h"

/* EEPM1:0: erase and write, erase only, write only (a write can only clear bits). */
static uint8_t programmed(hw *h, uint8_t old, uint8_t value) {
    switch (avr_regbit_get_array(h->avr, h->eeprom->eepm, 2)) {
        case 1: return 0xff;
        case 2: return old & value;
        default: return value;
    }
}

static uint16_t address(hw *h) {
    avr_eeprom_t *e = h->eeprom;
    uint16_t high = e->r_eearh ? (uint16_t)(h->avr->data[e->r_eearh] << 8) : 0;
    return (uint16_t)((high | h->avr->data[e->r_eearl]) & (e->size - 1));
}

static void begin(hw *h, uint16_t at, uint8_t old) {
    double cycles = h->eeprom_seconds * h->avr->frequency;
    h->eeprom->eeprom[at] = programmed(h, old, h->avr->data[h->eeprom->r_eedr]);
    h->eeprom_address = at;
    h->eeprom_old = old;
    h->eeprom_new = h->eeprom->eeprom[at];
    h->eeprom_busy = 1;
    h->eeprom_writes++;
    avr_regbit_clear(h->avr, h->eeprom->eempe);
    avr_clear_interrupt(h->avr, &h->eeprom->ready);
    avr_regbit_set(h->avr, h->eeprom->eepe);
    timer_set(h->eeprom_timer, h->avr->cycle + (uint64_t)cycles);
}

/* EE_READY is requested while it is enabled and no write is in progress. */
static void ask(hw *h) {
    if (!h->eeprom_busy && avr_regbit_get(h->avr, h->eeprom->ready.enable))
        avr_raise_interrupt(h->avr, &h->eeprom->ready);
}

static void on_ready(hw *h, void *param, uint64_t when) {
    (void)param, (void)when;
    h->eeprom_busy = 0;
    avr_regbit_clear(h->avr, h->eeprom->eepe);
    ask(h);
}

static void on_left(struct avr_irq_t *irq, uint32_t running, void *param) {
    (void)irq;
    if (!running)
        ask(param);
}

static void on_control(struct avr_t *avr, avr_io_addr_t a, uint8_t v, void *param) {
    hw *h = param;
    avr_eeprom_t *e = h->eeprom;
    uint8_t starts = (uint8_t)(1 << e->eepe.bit | 1 << e->eere.bit);
    uint16_t at = address(h);
    uint8_t old = e->eeprom[at];
    if (h->eeprom_busy && (v & starts)) {
        h->eeprom_violations += (v >> e->eere.bit & 1) ||
            (!(avr->data[a] >> e->eepe.bit & 1));
        v &= (uint8_t)~starts;
    }
    int enabled = avr_regbit_get(avr, e->ready.enable);
    int writes = (v >> e->eepe.bit & 1) && avr_regbit_get(avr, e->eempe);
    if (writes)
        v &= (uint8_t)~(1u << e->eepe.bit);
    h->tap_eecr.write(avr, a, v, h->tap_eecr.write_param);
    if (writes)
        begin(h, at, old);
    if (h->eeprom_busy)
        avr_regbit_set(avr, e->eepe);
    if (!enabled)
        ask(h);
}

void eeprom_init(hw *h) {
    h->eeprom = (avr_eeprom_t *)io_find(h, "eeprom", 0);
    if (!h->eeprom)
        return;
    h->eeprom_timer = timer_new(h, on_ready, NULL);
    tap_write(h, h->eeprom->r_eecr, on_control, h, &h->tap_eecr);
    avr_irq_register_notify(h->eeprom->ready.irq + AVR_INT_IRQ_RUNNING, on_left, h);
}

/* A write that has begun is completed even during a reset. */
void eeprom_reset(hw *h) {
    if (h->eeprom_busy)
        avr_regbit_set(h->avr, h->eeprom->eepe);
}

int hw_eeprom_size(hw *h) { return h->eeprom ? h->eeprom->size : 0; }

void hw_eeprom_get(hw *h, uint8_t *into) {
    if (h->eeprom)
        memcpy(into, h->eeprom->eeprom, h->eeprom->size);
}

void hw_eeprom_set(hw *h, const uint8_t *from) {
    if (h->eeprom)
        memcpy(h->eeprom->eeprom, from, h->eeprom->size);
}

void hw_eeprom_write_time(hw *h, double seconds) { h->eeprom_seconds = seconds; }

int hw_eeprom_writing(hw *h, uint16_t *at, uint8_t *old, uint8_t *new_value) {
    *at = h->eeprom_address;
    *old = h->eeprom_old;
    *new_value = h->eeprom_new;
    return h->eeprom_busy;
}

uint64_t hw_eeprom_writes(hw *h) { return h->eeprom_writes; }
uint64_t hw_eeprom_violations(hw *h) { return h->eeprom_violations; }
