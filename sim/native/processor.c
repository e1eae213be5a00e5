/* One processor: creation, run loop, resets. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <simavr/avr_extint.h>
#include "core/fast.h"
#include "core/profile.h"
#include "peripherals/parts.h"

#define YIELD_NS 50000000L
#define LOOK_CYCLES 400000      /* cycles between checks of the wall clock: under 10 ms */
#define SLEEP_OPCODE 0x9588
#define WAKE_CYCLES 4
#define RESET_FLAGS 0x1f        /* in MCUSR; MCUCSR of the oldest parts has other bits */

/* Receive simavr's messages; custom.data points to our structure. */
static void logger(struct avr_t *avr, const int level, const char *format, va_list args) {
    if (!avr || level > LOG_ERROR || !avr->custom.data)
        return;
    hw *h = avr->custom.data;
    vsnprintf(h->message, sizeof h->message, format, args);
}

/* Stop simavr from polling a low INT pin in every cycle; needed again after each reset. */
static void relax_external_interrupts(hw *h) {
    for (int i = 0; i < EXTINT_COUNT; i++)
        avr_extint_set_strict_lvl_trig(h->avr, (uint8_t)i, 0);
}

static void on_stop(hw *h, void *param, uint64_t when) {
    (void)h, (void)param, (void)when;
}

hw *hw_new(const char *mcu, uint32_t clock_hz, uint32_t supply_mv) {
    static const size_t records[] = {
        [HW_PIN_LOG] = sizeof(hw_pin_event), [HW_UART_LOG] = sizeof(hw_uart_byte),
        [HW_RESET_LOG] = sizeof(hw_reset_event), [HW_ENTRY_LOG] = sizeof(hw_entry),
    };
    avr_global_logger_set(logger);
    avr_t *avr = avr_make_mcu_by_name(mcu);
    hw *h = avr ? calloc(1, sizeof *h) : NULL;
    if (!h)
        return NULL;
    h->avr = avr;
    avr->custom.data = h;
    avr_init(avr);
    avr->frequency = clock_hz;
    avr->vcc = avr->avcc = avr->aref = supply_mv;
    h->avcc_mv = h->aref_mv = supply_mv;
    h->entry_cycles = avr->address_size == 3 ? 5 : 4;
    for (size_t i = 0; i < sizeof records / sizeof *records; i++)
        h->logs[i].record = records[i];
    h->stop = timer_new(h, on_stop, NULL);
    pins_init(h);
    compare_init(h);
    uart_init(h);
    adc_init(h);
    eeprom_init(h);
    watchdog_init(h);
    relax_external_interrupts(h);
    fast_init(h);
    return h;
}

/* Free IRQs that avr_terminate does not: those of the interrupt vectors and of the registers. */
static void free_remains(avr_t *avr) {
    for (int i = 0; i < avr->interrupts.vector_count; i++)
        avr_free_irq(avr->interrupts.vector[i]->irq, AVR_INT_IRQ_COUNT);
    avr_free_irq(avr->interrupts.irq, AVR_INT_IRQ_COUNT);
    for (int i = 0; i < MAX_IOs; i++)
        if (avr->io[i].irq)
            avr_free_irq(avr->io[i].irq, 9);
}

void hw_free(hw *h) {
    if (!h)
        return;
    uart_free(h);
    for (int i = 0; i < h->chip_count; i++)
        free(h->chips[i]);
    profile_free(h);
    fast_free(h);
    compare_free(h);
    for (int i = 0; i < HW_LOGS; i++)
        free(h->logs[i].data);
    free_remains(h->avr);
    avr_terminate(h->avr);
    free(h->avr->irq_pool.irq);
    free(h->avr);
    free(h);
}

static void log_reset(hw *h, int cause, uint32_t pc) {
    hw_reset_event *e = log_add(h, HW_RESET_LOG);
    e->cycle = h->avr->cycle;
    e->pc = pc;
    e->cause = (uint8_t)cause;
    e->mcusr = h->avr->data[h->avr->reset_flags.wdrf.reg];
}

/* Restore our cycle timers, which simavr deletes at a reset: the world outside goes on. */
static void rearm_timers(hw *h) {
    for (int i = 0; i < h->timer_count; i++)
        if (h->timers[i].armed)
            timer_set(&h->timers[i], h->timers[i].due);
}

void hw_reset(hw *h, int cause) {
    avr_t *avr = h->avr;
    uint32_t pc = avr->pc;
    uint8_t earlier = avr->data[avr->reset_flags.wdrf.reg];  /* flags add up until cleared */
    if (cause == HW_WATCHDOG)
        avr->run(avr);          /* simavr's own reset, which restarts the watchdog */
    else
        avr_reset(avr);
    avr->run = avr_callback_run_raw;
    if (cause == HW_EXTERNAL)
        avr_regbit_set(avr, avr->reset_flags.extrf);
    if (cause == HW_BROWN_OUT)
        avr_regbit_set(avr, avr->reset_flags.borf);
    avr->data[avr->reset_flags.wdrf.reg] |= earlier & RESET_FLAGS;
    old_reset(h);
    h->dead_sleep = 0;
    rearm_timers(h);
    relax_external_interrupts(h);
    uart_reset(h);
    eeprom_reset(h);
    compare_reset(h);
    pins_reset(h);
    snapshots_reset(h);
    if (h->profile)
        profile_reset(h);
    log_reset(h, cause, pc);
}

/* The part takes 4 cycles to enter an interrupt (5 with 3-byte addresses), simavr none. */
static void charge(avr_t *avr, int cycles) {
    avr->cycle += (avr_cycle_count_t)cycles;
    avr->run_cycle_count = avr->run_cycle_count > (avr_cycle_count_t)cycles
        ? avr->run_cycle_count - (avr_cycle_count_t)cycles : 1;
}

/* Remove the vector of the highest priority from the queue; the first one moves to its place. */
static avr_int_vector_t *take_next(avr_t *avr) {
    enum { SIZE = avr_int_pending_fifo_size };
    avr_int_pending_t *queue = &avr->interrupts.pending;
    unsigned first = queue->read;
    for (unsigned at = first; at != queue->write; at = (at + 1) % SIZE)
        if (queue->buffer[at]->vector < queue->buffer[first]->vector)
            first = at;
    avr_int_vector_t *vector = queue->buffer[first];
    queue->buffer[first] = queue->buffer[queue->read];
    queue->read = (uint16_t)((queue->read + 1) % SIZE);
    return vector;
}

/* As avr_service_interrupts, if interrupts are enabled and one waits. */
static void enter(hw *h) {
    avr_t *avr = h->avr;
    avr_int_table_t *table = &avr->interrupts;
    avr_int_vector_t *vector = take_next(avr);
    int more = waiting(avr);
    raise_irq(table->irq + AVR_INT_IRQ_PENDING, (uint32_t)more);
    if (!avr_regbit_get(avr, vector->enable) || !vector->pending) {
        vector->pending = 0;
        avr->interrupt_state = more;
        return;
    }
    _avr_push_addr(avr, avr->pc);
    avr_sreg_set(avr, S_I, 0);
    avr->pc = (avr_flashaddr_t)vector->vector * avr->vector_size;
    raise_irq(vector->irq + AVR_INT_IRQ_RUNNING, 1);
    raise_irq(table->irq + AVR_INT_IRQ_RUNNING, vector->vector);
    if (table->running_ptr < sizeof table->running / sizeof *table->running)
        table->running[table->running_ptr++] = vector;
    avr_clear_interrupt(avr, vector);
}

static void service(hw *h, int extra) {
    avr_t *avr = h->avr;
    int enabled = avr->sreg[S_I];
    uint16_t sp = hw_stack_pointer(h);
    if (sp > avr->ramend || sp < avr->address_size) {
        crash(h, "interrupt with the stack outside the memory");
        return;
    }
    if (enabled && avr->interrupt_state > 0 && waiting(avr))
        enter(h);
    else
        avr_service_interrupts(avr);
    if (!enabled || avr->sreg[S_I])
        return;                                 /* no interrupt was entered */
    charge(avr, h->entry_cycles + extra);
    if (h->profile)
        profile_interrupt(h);
}

static void check_sleep_mode(hw *h) {
    if (h->sleep_register && (h->avr->data[h->sleep_register] & h->sleep_mode))
        limit(h, "sleep mode other than idle at 0x%04x: simavr does not stop clocks", h->avr->pc);
}

static int may_sleep(hw *h) {
    return !h->sleep_register || (h->avr->data[h->sleep_register] & h->sleep_enable);
}

/* Run one instruction, with simavr's core if there is a mark or a profile, or with our core at the
   start of a profile. */
static avr_flashaddr_t step(hw *h) {
    if (h->reference && h->avr->pc == h->mark)
        snapshots_take(h, h->mark);
    if (h->profile)
        profile_before(h);
    avr_flashaddr_t pc = h->reference ? avr_run_one(h->avr) : fast_run(h);
    if (h->profile)
        profile_after(h, pc);
    return pc;
}

static avr_flashaddr_t burst(hw *h) {
    avr_t *avr = h->avr;
    int stepped = h->reference ? h->profile || h->mark != HW_AT_SLEEP
                               : h->profile && !profile_settled(h);
    if (stepped || avr->interrupt_state)
        avr->run_cycle_count = 1;
    avr->run_cycle_limit = stepped ? 1 : BURST;
    avr_flashaddr_t pc = stepped ? step(h) : h->profile ? profiled_run(h)
                       : h->reference ? avr_run_one(avr) : fast_run(h);
    avr->run_cycle_limit = stepped ? 1 : BURST;
    return pc;
}

/* Run a burst of instructions. A SLEEP with a waiting interrupt ends at once, and the interrupt
   comes before the next instruction; simavr would run that instruction first. */
static avr_flashaddr_t execute(hw *h) {
    avr_t *avr = h->avr;
    if (avr->interrupt_state >= 0)
        return burst(h);
    int sleeps = avr->pc < avr->flashend
              && (avr->flash[avr->pc] | avr->flash[avr->pc + 1] << 8) == SLEEP_OPCODE;
    avr_flashaddr_t pc = burst(h);
    if (sleeps && avr->state == cpu_Running && avr->sreg[S_I] && may_sleep(h)) {
        avr->interrupt_state = 1;
        snapshots_take(h, HW_AT_SLEEP);
    }
    return pc;
}

static void fall_asleep(hw *h) {
    if (!may_sleep(h)) {
        h->avr->state = cpu_Running;
        return;
    }
    check_sleep_mode(h);
    snapshots_take(h, HW_AT_SLEEP);
    h->dead_sleep = !h->avr->sreg[S_I];
    if (h->profile)
        profile_sleep(h);
}

/* Let time pass until the next timer, but not past the cycle to stop at. */
static void sleep_on(hw *h, avr_cycle_count_t cycles) {
    h->avr->cycle += cycles;
    h->sleep_cycles += cycles;
    if (h->profile)
        profile_slept(h, cycles);
}

/* Serve the waking interrupt before the instruction after SLEEP, 4 cycles late. */
static void wake(hw *h) {
    h->avr->interrupt_state = 1;
    service(h, WAKE_CYCLES);
}

static void turn(hw *h) {
    avr_t *avr = h->avr;
    int awake = avr->state == cpu_Running, asleep;
    avr_flashaddr_t pc = avr->pc;
    if (awake) {
        pc = execute(h);
        if (avr->state == cpu_Sleeping)
            fall_asleep(h);
    }
    asleep = avr->state == cpu_Sleeping;
    avr_cycle_count_t idle = pass_timers(avr);
    avr->pc = pc;
    if (avr->run != avr_callback_run_raw) {     /* the watchdog has reset it */
        hw_reset(h, HW_WATCHDOG);
        return;
    }
    if (h->dead_sleep && avr->state == cpu_Running)
        avr->state = cpu_Sleeping;              /* interrupts off: only a reset wakes it */
    if (avr->state == cpu_Sleeping)
        sleep_on(h, idle);
    else if (asleep)
        wake(h);
    else if (avr->interrupt_state)
        service(h, 0);
}

static long elapsed_ns(const struct timespec *start) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (now.tv_sec - start->tv_sec) * 1000000000L + now.tv_nsec - start->tv_nsec;
}

static int over(hw *h) {
    if (h->limit)
        return HW_LIMIT;
    if (h->avr->state == cpu_Crashed || h->avr->state == cpu_Done)
        return HW_CRASHED;
    return 0;
}

int hw_run(hw *h, uint64_t until) {
    struct timespec start;
    clock_gettime(CLOCK_MONOTONIC, &start);
    h->until = until;
    timer_set(h->stop, until);
    uint64_t looked = h->avr->cycle - h->sleep_cycles;
    for (unsigned n = 1; h->avr->cycle < until; n++) {
        turn(h);
        int ended = over(h);
        if (ended)
            return ended;
        if (h->log_full)
            return HW_YIELD;
        uint64_t executed = h->avr->cycle - h->sleep_cycles;
        if (n % 1024 && executed - looked < LOOK_CYCLES)
            continue;
        looked = executed;
        if (elapsed_ns(&start) > YIELD_NS)
            return HW_YIELD;
    }
    return HW_DONE;
}

/* Run one instruction or, when asleep, let time pass to the next timer. */
static int advance(hw *h, uint64_t until) {
    if (h->avr->state != cpu_Sleeping)
        return hw_run(h, h->avr->cycle + 1);
    h->until = until;
    timer_set(h->stop, until);
    turn(h);
    int ended = over(h);
    return ended ? ended : h->log_full ? HW_YIELD : HW_DONE;
}

/* Returns HW_NEWS: the next instruction is within the code. Runs at least one instruction. */
int hw_run_to_code(hw *h, uint32_t start, uint32_t end, uint64_t until) {
    while (h->avr->cycle < until) {
        int ended = advance(h, until);
        if (ended)
            return ended;
        if (h->avr->pc >= start && h->avr->pc < end)
            return HW_NEWS;
    }
    return HW_DONE;
}
