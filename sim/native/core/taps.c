/* Our own handlers of registers, and changes of the flash: both discard the decoded code. */
#include "fast.h"

void tap_write(hw *h, avr_io_addr_t address, avr_io_write_t ours, void *param, struct tap *tap) {
    avr_io_addr_t a = AVR_DATA_TO_IO(address);
    tap->write = h->avr->io[a].w.c;
    tap->write_param = h->avr->io[a].w.param;
    h->avr->io[a].w.c = ours;
    h->avr->io[a].w.param = param;
    fast_forget(h);
}

void tap_read(hw *h, avr_io_addr_t address, avr_io_read_t ours, void *param, struct tap *tap) {
    avr_io_addr_t a = AVR_DATA_TO_IO(address);
    tap->read = h->avr->io[a].r.c;
    tap->read_param = h->avr->io[a].r.param;
    h->avr->io[a].r.c = ours;
    h->avr->io[a].r.param = param;
    fast_forget(h);
}

void hw_flash_changed(hw *h) { fast_forget(h); }
