// SPDX-License-Identifier: GPL-3.0-or-later
// Runs a binary in libsimavr's own loop, and prints the processor time of that, s.
// Arguments: ELF, part, clock in Hz, cycles.
#include <simavr/avr_extint.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

// simavr would wait in real time while the program sleeps.
static void no_wait(avr_t *avr, avr_cycle_count_t cycles) {
    (void)avr;
    (void)cycles;
}

static double processor_s(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

int main(int count, char **words) {
    elf_firmware_t firmware = {0};
    if (count != 5 || elf_read_firmware(words[1], &firmware) != 0) return 2;
    avr_t *avr = avr_make_mcu_by_name(words[2]);
    if (avr == NULL || avr_init(avr) != 0) return 2;
    firmware.frequency = (uint32_t)atol(words[3]);
    avr_load_firmware(avr, &firmware);
    avr->log = LOG_NONE;
    avr->sleep = no_wait;
    // A pin of an interrupt that is low would be looked at in every cycle, also asleep.
    for (uint8_t pin = 0; pin < 2; pin++) avr_extint_set_strict_lvl_trig(avr, pin, 0);
    const avr_cycle_count_t end = strtoull(words[4], NULL, 10);
    const double start = processor_s();
    while (avr->cycle < end) {
        const int state = avr_run(avr);
        if (state == cpu_Done || state == cpu_Crashed) return 1;
    }
    printf("%.6f\n", processor_s() - start);
    return 0;
}
