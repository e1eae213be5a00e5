/* Watchdog: a new timeout takes effect at once; in simavr only at the next WDR. */
#include "parts.h"

static uint8_t prescaler(hw *h) { return avr_regbit_get_array(h->avr, h->watchdog->wdp, 4); }

static void on_control(struct avr_t *avr, avr_io_addr_t a, uint8_t v, void *param) {
    hw *h = param;
    uint8_t before = prescaler(h);
    h->tap_wdtcsr.write(avr, a, v, h->tap_wdtcsr.write_param);
    if (prescaler(h) != before)
        avr_ioctl(avr, AVR_IOCTL_WATCHDOG_RESET, NULL);
}

void watchdog_init(hw *h) {
    h->watchdog = (avr_watchdog_t *)io_find(h, "watchdog", 0);
    if (h->watchdog)
        tap_write(h, h->watchdog->wdce.reg, on_control, h, &h->tap_wdtcsr);
}
