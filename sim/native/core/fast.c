/* The processor's core: instructions decoded once, run from a table.

   simavr decodes an instruction each time it runs; this core takes a third of that time. It does the
   same as simavr's core, flag by flag and cycle by cycle (a test runs both on random code), leaves
   rare instructions to it, and calls the handlers of peripheral registers as simavr does. In three
   cases it follows the real chip, and simavr does not: SBI on a PIN register toggles only that bit,
   SBI and CBI of a port's bit that already has the value change no pin, and a skip over ADIW or SBIW
   skips one word. */
#include <stdlib.h>
#include <string.h>
#include "decode.h"
#include "fast.h"

struct fast {
    struct decoded *code;       /* one for each word of flash, and one beyond */
    uint8_t special[SPECIAL];
    struct part part;
    uint8_t marked;             /* the operation at the mark */
};

#ifndef PROFILED
#define PROFILED(...)           /* code for profiled.c only, which includes this file */

static void mark_special(hw *h) {
    uint8_t *special = h->fast->special;
    memset(special, 0, SPECIAL);
    for (int i = 0; i < MAX_IOs; i++) {
        int any = h->avr->io[i].irq != NULL;
        special[i + 32] = (uint8_t)((any || h->avr->io[i].r.c ? SPECIAL_READ : 0) |
                                    (any || h->avr->io[i].w.c ? SPECIAL_WRITE : 0) |
                                    (h->profile ? SPECIAL_PROFILED : 0));
    }
    special[R_SREG] = SPECIAL_READ | SPECIAL_WRITE;
    for (int i = 0; i < HW_PORTS; i++)
        if (h->ports[i].io) {
            special[h->ports[i].io->r_pin] |= SPECIAL_PIN;
            special[h->ports[i].io->r_port] |= SPECIAL_PORT;
        }
    if (h->profile)             /* it needs the lowest stack pointer */
        special[R_SPL] = special[R_SPH] |= SPECIAL_WRITE;
}

/* Discard the decoded code after the flash or the registers' handlers have changed. */
void fast_forget(hw *h) {
    if (!h->fast)
        return;
    mark_special(h);
    memset(h->fast->code, 0, (h->avr->flashend / 2 + 1) * sizeof *h->fast->code);
}

void fast_init(hw *h) {
    size_t words = h->avr->flashend / 2 + 1;
    h->fast = calloc(1, sizeof *h->fast);
    if (!h->fast || !(h->fast->code = calloc(words + 1, sizeof *h->fast->code)))
        abort();
    h->fast->part = (struct part){.flash = h->avr->flash, .flash_end = h->avr->flashend,
                                  .ram_end = h->avr->ramend, .special = h->fast->special};
    h->fast->code[words].op = SLOW;
    h->mark = HW_AT_SLEEP;
    fast_forget(h);
}

/* Take the snapshots of the code at an address before each time that it runs. Returns 0 if there is
   another such address. */
int fast_mark(hw *h, uint32_t at) {
    if (h->mark != HW_AT_SLEEP && h->mark != at)
        return 0;
    h->mark = at;
    fast_forget(h);
    return 1;
}

void fast_free(hw *h) {
    if (h->fast)
        free(h->fast->code);
    free(h->fast);
}
#endif

#define Rd (D[i->d])
#define Rr (D[i->r])
#define PAIR(n) load_pair(D + (n))
#define SET_PAIR(n, v) store_pair(D + (n), (uint16_t)(v))
#define POINTER PAIR(i->n)
#define SET_POINTER(v) SET_PAIR(i->n, v)
#define K ((uint8_t)i->k)
#define BIT(v, n) ((uint8_t)((v) >> (n) & 1))

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "register pairs are read as the host's own words"
#endif

static inline uint16_t load_pair(const uint8_t *from) {
    uint16_t pair;
    memcpy(&pair, from, sizeof pair);
    return pair;
}

static inline void store_pair(uint8_t *into, uint16_t pair) { memcpy(into, &pair, sizeof pair); }

/* The flags during a burst, in forms that are fast to set: C is 0 or 1, Z is set if z is 0, N, V and
   S are bit 7, H is bit 4 of their bytes. T and I stay in simavr's array. */
struct flags {
    unsigned c, z, n, v, s, h;
};

static inline struct flags unpacked(unsigned sreg) {
    return (struct flags){.c = sreg & 1, .z = ~sreg & 2, .n = sreg << 5, .v = sreg << 4,
                          .s = sreg << 3, .h = sreg >> 1};
}

static inline unsigned packed(const struct flags *f) {
    return f->c | (unsigned)!f->z << 1 | (f->n >> 5 & 4) | (f->v >> 4 & 8) | (f->s >> 3 & 16) |
           (f->h << 1 & 32);
}

/* The eight flags, each a byte of 0 or 1, as one byte: the multiplication moves them side by side. */
static inline struct flags flags_from(const uint8_t *S) {
    uint64_t flags;
    memcpy(&flags, S, sizeof flags);
    return unpacked((uint8_t)(flags * 0x0102040810204080u >> 56));
}

/* The reverse: each byte gets its bit, which adding 0x7f moves to the top. */
static inline void flags_into(uint8_t *S, const struct flags *f) {
    uint64_t each = packed(f) * 0x0101010101010101u & 0x0000201008040201u;
    each = (each + 0x007f7f7f7f7f7fu) >> 7 & 0x0000010101010101u;
    memcpy(S, &each, S_T);
}

/* In all these functions a and b are the 8-bit operands, res is the result. */
static inline void zns(struct flags *f, unsigned res) {
    f->z = f->n = res;
    f->s = res ^ f->v;
}

static inline unsigned add(struct flags *f, unsigned a, unsigned b, unsigned carry) {
    unsigned sum = a + b + carry, res = (uint8_t)sum;
    f->c = sum >> 8;
    f->h = a ^ b ^ res;
    f->v = (a ^ res) & (b ^ res);
    zns(f, res);
    return res;
}

static inline unsigned subtract(struct flags *f, unsigned a, unsigned b, unsigned borrow) {
    unsigned difference = a - b - borrow, res = (uint8_t)difference;
    f->c = difference >> 31;
    f->h = a ^ b ^ res;
    f->v = (a ^ b) & (a ^ res);
    zns(f, res);
    return res;
}

/* SBC, SBCI, CPC: Z stays set only if it was set and the result is 0 (z is 0 while Z is set). */
static inline unsigned subtract_on(struct flags *f, unsigned a, unsigned b) {
    unsigned zero = f->z, res = subtract(f, a, b, f->c);
    f->z |= zero;
    return res;
}

static inline unsigned logic(struct flags *f, unsigned res) {
    f->v = 0;
    zns(f, res);
    return res;
}

static inline unsigned shift(struct flags *f, unsigned res, unsigned before) {
    f->c = before & 1;
    f->v = res ^ f->c << 7;
    zns(f, res);
    return res;
}

static inline unsigned word(struct flags *f, unsigned res, unsigned overflow, unsigned carry) {
    f->c = carry >> 15 & 1;
    f->v = overflow >> 8;
    f->n = res >> 8;
    f->s = f->n ^ f->v;
    f->z = res;
    return res;
}

static inline void product(uint8_t *D, struct flags *f, unsigned res) {
    SET_PAIR(0, res);
    f->z = (uint16_t)res;
    f->c = res >> 15 & 1;
}

/* Push an address of two or three bytes; returns the stack pointer after it. */
static inline uint16_t push_address(uint8_t *D, uint16_t sp, uint32_t address, int size) {
    D[sp] = (uint8_t)address;
    D[sp - 1] = (uint8_t)(address >> 8);
    if (size == 3)
        D[sp - 2] = (uint8_t)(address >> 16);
    return (uint16_t)(sp - size);
}

/* Returns the stack pointer after a return, and its target; 0 if the target is beyond the flash. */
static inline uint16_t pop_address(avr_t *avr, uint16_t sp, uint32_t *target) {
    int size = avr->address_size;
    const uint8_t *top = avr->data + sp + size;
    uint32_t back = (uint32_t)(top[-1] << 8 | top[0]) | (size == 3 ? (uint32_t)top[-2] << 16 : 0);
    *target = 2 * back;
    return 2 * back < avr->flashend ? (uint16_t)(sp + size) : 0;
}

/* An interrupt comes one instruction after I was set; the burst must end for that. */
static inline int enable(avr_t *avr) {
    int change = !avr->sreg[S_I];
    if (change)
        avr->interrupt_state = -2;
    avr->sreg[S_I] = 1;
    return change;
}

/* Whether the burst may go on after I was set: no interrupt waits, no timer is due until the next
   instruction ends, and that reaches neither a register with handlers nor the end of the stack. */
static inline int settles(const avr_t *avr, const struct decoded *i, int32_t left) {
    enum { LONGEST = 5, DEEPEST = 4 };  /* cycles, bytes */
    static const uint8_t plain[256] = {
        [NOP] = 1, [MOVW] = 1, [ADD] = 1, [ADC] = 1, [SUB] = 1, [SBC] = 1, [AND] = 1, [OR] = 1,
        [EOR] = 1, [MOV] = 1, [CP] = 1, [CPC] = 1, [CPSE] = 1, [CPI] = 1, [SBCI] = 1, [SUBI] = 1,
        [ORI] = 1, [ANDI] = 1, [LDI] = 1, [ADIW] = 1, [SBIW] = 1, [LDS] = 1, [STS] = 1, [IN] = 1,
        [OUT] = 1, [PUSH] = 1, [POP] = 1, [SBI] = 1, [CBI] = 1, [SBRC] = 1, [SBRS] = 1, [BREQ] = 1,
        [BRNE] = 1, [BRCS] = 1, [BRCC] = 1, [BRLT] = 1, [BRGE] = 1, [BRMI] = 1, [BRPL] = 1,
        [JUMP] = 1, [CALL] = 1, [RET] = 1,
    };
    uint16_t sp = load_pair(avr->data + R_SPL);
    return plain[i->op] && left > LONGEST && !waiting(avr) && sp > SPECIAL + DEEPEST &&
           sp + DEEPEST <= avr->ramend;
}

static inline void disable(avr_t *avr) {
    avr->interrupt_state = 0;
    avr->sreg[S_I] = 0;
}

static uint16_t word_at(const avr_t *avr, uint32_t pc) {
    return pc < avr->flashend ? load_pair(avr->flash + pc) : 0;
}

static int skips(uint16_t op) {
    return (op & 0xfc00) == 0x1000 || (op & 0xfc08) == 0xfc00 ||    /* CPSE; SBRC, SBRS */
           (op & 0xfd00) == 0x9900;                                 /* SBIC, SBIS */
}

/* simavr 1.6 treats ADIW and SBIW with K & 12 == 12 as two-word instructions: when it skips one, it
   goes one word too far, and takes one cycle too many. */
static avr_flashaddr_t mended_skip(avr_t *avr, uint32_t pc, avr_flashaddr_t next) {
    int mistaken = (word_at(avr, pc + 2) & 0xfe0c) == 0x960c;
    if (next != pc + 6 || !mistaken || !skips(word_at(avr, pc)))
        return next;
    avr->cycle--;
    return pc + 4;
}

static avr_flashaddr_t leave_to_simavr(hw *h, uint32_t pc) {
    avr_t *avr = h->avr;
    int writes_flash = word_at(avr, pc) == 0x95e8;
    avr->pc = pc;
    avr->run_cycle_limit = avr->run_cycle_count = 1;    /* only this instruction */
    PROFILED(profile_before(h);)
    avr_flashaddr_t next = avr_run_one(avr);
    if (writes_flash)
        fast_forget(h);
    next = mended_skip(avr, pc, next);
    PROFILED(profile_after(h, next);)
    return next;
}

static avr_flashaddr_t toggle(avr_t *avr, uint32_t pc, uint8_t address, uint8_t mask) {
    avr_io_addr_t a = AVR_DATA_TO_IO(address);
    avr->pc = pc;
    avr->io[a].w.c(avr, address, mask, avr->io[a].w.param);
    avr->cycle += 2;
    return pc + 2;
}

/* Read a register with handlers as simavr does. */
static uint8_t read_register(avr_t *avr, uint16_t address) {
    const avr_io_addr_t a = AVR_DATA_TO_IO(address);
    if (avr->io[a].r.c)
        avr->data[address] = avr->io[a].r.c(avr, address, avr->io[a].r.param);
    raise_register(avr, address, avr->data[address]);
    return avr->data[address];
}

/* As avr_interrupt_reti. */
static void end_interrupt(avr_t *avr) {
    avr_int_table_t *table = &avr->interrupts;
    if (table->running_ptr)
        raise_irq(table->running[--table->running_ptr]->irq + AVR_INT_IRQ_RUNNING, 0);
    raise_irq(table->irq + AVR_INT_IRQ_RUNNING,
              table->running_ptr ? table->running[table->running_ptr - 1]->vector : 0);
    raise_irq(table->irq + AVR_INT_IRQ_PENDING, (uint32_t)waiting(avr));
}

/* Whether the burst may go on after simavr, a handler or a timer acted: no interrupt, no timer, no
   end of the run, and no check of the clock is due. During a profile it always ends. */
static inline int goes_on(const hw *h, uint32_t pc, avr_cycle_count_t last) {
    const avr_t *avr = h->avr;
    const avr_cycle_timer_slot_p next = avr->cycle_timers.timer;
    return avr->state == cpu_Running && !avr->interrupt_state && avr->run == avr_callback_run_raw &&
           !h->limit && !h->log_full && !h->profile && pc < avr->flashend && next &&
           next->when > avr->cycle && avr->cycle < last;
}

/* Cycles to the next timer, as simavr counts them. */
static int32_t budget_of(const avr_t *avr) {
    avr_cycle_count_t most = avr->cycle_timers.timer->when - avr->cycle;
    return (int32_t)(most < BURST ? most : BURST);
}

/* Each label is an instruction; NEXT goes to the label of the instruction at i. */
#define PC ((uint32_t)(i - code) * 2)
#define AT(pc) (code + (uint32_t)(pc) / 2)

/* NEXT counts the cycles of this instruction; SPEND adds them and those before to avr->cycle. */
#define SPEND(cycles) \
    (avr->cycle += (uint32_t)(budget - left + (cycles)), budget = left - (int32_t)(cycles))
#define NEXT(cycles) do { \
        if ((left -= (int32_t)(cycles)) <= 0) \
            goto out; \
        PROFILED(if (PC - p->from >= p->size) goto crossed;) \
        goto *labels[i->op]; \
    } while (0)
#define LEAVE(cycles) do { left -= (int32_t)(cycles); goto out; } while (0)
#define ENABLED(cycles) do { \
        if (PROFILED(0 &&) settles(avr, i, left - (int32_t)(cycles))) { \
            avr->interrupt_state = 0; \
            NEXT(cycles); \
        } \
        LEAVE(cycles); \
    } while (0)
#define TOGETHER (PROFILED(1 ? 1 :) (left + 1) / 2 < i->n ? (left + 1) / 2 : i->n)
#define DONE(cycles) do { i++; NEXT(cycles); } while (0)
#define GO(cycles) do { \
        int32_t taken = (int32_t)(cycles); \
        PROFILED(profile_jump(p, PC);) \
        i = AT(i->k); \
        NEXT(taken); \
    } while (0)
#define SKIP(condition) do { \
        if (condition) \
            GO(i->n); \
        DONE(1); \
    } while (0)
/* Code around a call of a register's handlers: pc and target are the next pc and the cycles. */
#define HANDLE(at) do { \
        SPEND(0); \
        avr->pc = PC; \
        avr->run_cycle_limit = avr->run_cycle_count = 1; \
        address = (uint16_t)(at); \
    } while (0)
#define HANDLED(next, cycles) do { pc = (next); target = (cycles); goto handled; } while (0)
/* Check an address: most are beyond all registers, and within the memory. */
#define CHECK(a, how) do { \
        if ((uint16_t)((a) - SPECIAL) > ram_end - SPECIAL) { \
            if ((a) > ram_end) \
                goto wild; \
            if (special[a] & (how)) \
                goto SLOW; \
        } \
    } while (0)
#define STACK(sp) do { \
        if ((uint16_t)((sp) - LEAST_STACK) > ram_end - LEAST_STACK) { \
            address = (uint16_t)(sp); \
            goto edge; \
        } \
    } while (0)

/* Run at most BURST cycles, up to h->until, or until simavr, a handler or a timer causes an
   interrupt or the end of the run; during a profile each of these ends it. Returns the next pc. */
avr_flashaddr_t fast_run(hw *h) {
#define LABEL(name) &&name,
    static const void *const labels[] = {OPERATIONS(LABEL)};
    avr_t *const avr = h->avr;
    uint8_t *const D = avr->data, *const S = avr->sreg;
    struct decoded *const code = h->fast->code, *i;
    const uint8_t *const special = h->fast->special;
    const uint16_t ram_end = avr->ramend;
    const avr_cycle_count_t last =
        h->until < avr->cycle + BURST ? h->until : avr->cycle + BURST;
    int32_t budget = (int32_t)avr->run_cycle_count;
    int32_t left = budget;
    uint16_t address, wide;
    uint32_t pc = avr->pc, target;
    int rounds;
    uint8_t a;
    struct flags f = flags_from(S);

    if (pc >= avr->flashend)
        return leave_to_simavr(h, pc);
    i = AT(pc);
    PROFILED(struct profile *const p = h->profile; profile_enter(h, pc); goto crossed;)
    goto *labels[i->op];

UNDECODED:
    PROFILED(p->coverage[i - code] = 1;)
    *i = decode(&h->fast->part, PC);
    if (PC == h->mark) {
        h->fast->marked = i->op;
        i->op = MARKED;
    }
    goto *labels[i->op];
MARKED: SPEND(0); snapshots_take(h, PC); goto *labels[h->fast->marked];
NOP: target = 1u + i->n; DONE(target);
MOVW: wide = PAIR(i->r); SET_PAIR(i->d, wide); DONE(1);
MULS: product(D, &f, (uint16_t)((int8_t)Rd * (int8_t)Rr)); DONE(2);
MUL: product(D, &f, (unsigned)Rd * Rr); DONE(2);
ADD: Rd = (uint8_t)add(&f, Rd, Rr, 0); DONE(1);
ADC: Rd = (uint8_t)add(&f, Rd, Rr, f.c); DONE(1);
SUB: Rd = (uint8_t)subtract(&f, Rd, Rr, 0); DONE(1);
SBC: Rd = (uint8_t)subtract_on(&f, Rd, Rr); DONE(1);
CP: subtract(&f, Rd, Rr, 0); DONE(1);
CPC: subtract_on(&f, Rd, Rr); DONE(1);
CPI: subtract(&f, Rd, K, 0); DONE(1);
SUBI: Rd = (uint8_t)subtract(&f, Rd, K, 0); DONE(1);
SBCI: Rd = (uint8_t)subtract_on(&f, Rd, K); DONE(1);
AND: Rd = (uint8_t)logic(&f, Rd & Rr); DONE(1);
OR: Rd = (uint8_t)logic(&f, Rd | Rr); DONE(1);
EOR: Rd = (uint8_t)logic(&f, Rd ^ Rr); DONE(1);
ORI: Rd = (uint8_t)logic(&f, Rd | K); DONE(1);
ANDI: Rd = (uint8_t)logic(&f, Rd & K); DONE(1);
MOV: Rd = Rr; DONE(1);
LDI: Rd = K; DONE(1);
ADIW:
    address = PAIR(i->d); wide = (uint16_t)(address + i->k);
    SET_PAIR(i->d, word(&f, wide, ~address & wide, ~wide & address)); DONE(2);
SBIW:
    address = PAIR(i->d); wide = (uint16_t)(address - i->k);
    SET_PAIR(i->d, word(&f, wide, address & ~wide, wide & ~address)); DONE(2);
COM: Rd = (uint8_t)logic(&f, (uint8_t)~Rd); f.c = 1; DONE(1);
NEG: Rd = (uint8_t)subtract(&f, 0, Rd, 0); DONE(1);
SWAP: Rd = (uint8_t)(Rd << 4 | Rd >> 4); DONE(1);
INC: a = ++Rd; f.v = (unsigned)(a == 0x80) << 7; zns(&f, a); DONE(1);
DEC: a = --Rd; f.v = (unsigned)(a == 0x7f) << 7; zns(&f, a); DONE(1);
DELAY:      /* three cycles a round, two for the last; before a timer is due, only whole rounds */
    PROFILED(goto DEC;)
    wide = (uint16_t)(left > 3 ? (left - 1) / 3 : 0); target = (uint8_t)(Rd - 1);
    if (wide > target)
        wide = (uint16_t)target;
    Rd = (uint8_t)(Rd - wide); left -= 3 * wide;
    goto DEC;
ASR: a = Rd; Rd = (uint8_t)shift(&f, (unsigned)(a >> 1 | (a & 0x80)), a); DONE(1);
LSR: a = Rd; Rd = (uint8_t)shift(&f, a >> 1, a); DONE(1);
ROR: a = Rd; Rd = (uint8_t)shift(&f, a >> 1 | f.c << 7, a); DONE(1);
BSET: flags_into(S, &f); S[i->d] = 1; f = flags_from(S); DONE(1);
BCLR: flags_into(S, &f); S[i->d] = 0; f = flags_from(S); DONE(1);
BST: S[S_T] = BIT(Rd, i->r); DONE(1);
BLD: Rd = (uint8_t)(S[S_T] ? Rd | i->r : Rd & ~i->r); DONE(1);
LDS: Rd = D[i->k]; i++; DONE(2);
STS: D[i->k] = Rd; i++; DONE(2);
IN: Rd = D[i->k]; DONE(1);
OUT: D[i->k] = Rd; DONE(1);
LDD: address = (uint16_t)(POINTER + i->k); CHECK(address, SPECIAL_READ); Rd = D[address]; DONE(2);
STD: address = (uint16_t)(POINTER + i->k); CHECK(address, SPECIAL_WRITE); D[address] = Rd; DONE(2);
LD_INC:
    address = POINTER; CHECK(address, SPECIAL_READ); a = D[address];
    SET_POINTER(address + 1); Rd = a; DONE(2);
ST_INC:
    address = POINTER; CHECK(address, SPECIAL_WRITE); D[address] = Rd;
    SET_POINTER(address + 1); DONE(2);
LD_DEC:
    address = (uint16_t)(POINTER - 1); CHECK(address, SPECIAL_READ); a = D[address];
    SET_POINTER(address); Rd = a; DONE(2);
ST_DEC:
    address = (uint16_t)(POINTER - 1); CHECK(address, SPECIAL_WRITE); D[address] = Rd;
    SET_POINTER(address); DONE(2);
PUSH:       /* as many in a row as the time allows, two cycles each */
    wide = PAIR(R_SPL); rounds = TOGETHER; STACK(wide); STACK(wide - rounds);
    do { D[wide--] = Rd; i++; left -= 2; } while (--rounds && i->op == PUSH);
    SET_PAIR(R_SPL, wide); PROFILED(profile_stack(p, wide);) NEXT(0);
POP:
    wide = PAIR(R_SPL); rounds = TOGETHER; STACK(wide + 1);
    if (wide + rounds > ram_end)
        rounds = 1;
    do { Rd = D[++wide]; i++; left -= 2; } while (--rounds && i->op == POP);
    SET_PAIR(R_SPL, wide); NEXT(0);
LPM: Rd = avr->flash[PAIR(R_ZL) & avr->flashend]; DONE(3);
LPM_INC: wide = PAIR(R_ZL); a = avr->flash[wide & avr->flashend]; Rd = a; SET_PAIR(R_ZL, wide + 1); DONE(3);
IN_SREG:
    Rd = D[R_SREG] = (uint8_t)(packed(&f) | (unsigned)S[S_T] << 6 | (unsigned)S[S_I] << 7); DONE(1);
OUT_SREG:
    a = D[R_SREG] = Rd; f = unpacked(a); S[S_T] = BIT(a, 6);
    if (!(a >> 7)) {
        disable(avr);
        PROFILED(SPEND(0); profile_mask(h, PC);)
    } else if (enable(avr)) {
        PROFILED(SPEND(1); profile_mask(h, PC);)
        i++;
        ENABLED(1);
    }
    DONE(1);
SBI: Rd |= i->r; DONE(2);
CBI: Rd &= (uint8_t)~i->r; DONE(2);
SBI_PORT:
    if (Rd & i->r) DONE(2);
    if (special[i->d] & SPECIAL_PROFILED) goto SLOW;
SBI_IO:
    HANDLE(i->d); a = read_register(avr, address);
    write_register(avr, address, a | i->r); HANDLED(PC + 2, 2);
CBI_PORT:
    if (!(Rd & i->r)) DONE(2);
    if (special[i->d] & SPECIAL_PROFILED) goto SLOW;
CBI_IO:
    HANDLE(i->d); a = read_register(avr, address);
    write_register(avr, address, (uint8_t)(a & ~i->r)); HANDLED(PC + 2, 2);
SBIC_IO:
    HANDLE(i->d); a = read_register(avr, address);
    if (a & i->r) HANDLED(PC + 2, 1);
    HANDLED((uint32_t)i->k, i->n);
SBIS_IO:
    HANDLE(i->d); a = read_register(avr, address);
    if (!(a & i->r)) HANDLED(PC + 2, 1);
    HANDLED((uint32_t)i->k, i->n);
IN_IO: HANDLE(i->k); a = read_register(avr, address); Rd = a; HANDLED(PC + 2, 1);
OUT_IO: HANDLE(i->k); write_register(avr, address, Rd); HANDLED(PC + 2, 1);
LDS_IO: HANDLE(i->k); a = read_register(avr, address); Rd = a; HANDLED(PC + 4, 2);
STS_IO: HANDLE(i->k); write_register(avr, address, Rd); HANDLED(PC + 4, 2);
SBI_PIN: SPEND(0); pc = toggle(avr, PC, i->d, i->r); goto gone;
SBRC: SKIP(!(Rd & i->r));
SBRS: SKIP(Rd & i->r);
CPSE: SKIP(Rd == Rr);
BRCS: SKIP(f.c);
BREQ: SKIP(!f.z);
BRMI: SKIP(f.n & 0x80);
BRVS: SKIP(f.v & 0x80);
BRLT: SKIP(f.s & 0x80);
BRHS: SKIP(f.h & 0x10);
BRTS: SKIP(S[S_T]);
BRIE: SKIP(S[S_I]);
BRCC: SKIP(!f.c);
BRNE: SKIP(f.z);
BRPL: SKIP(!(f.n & 0x80));
BRVC: SKIP(!(f.v & 0x80));
BRGE: SKIP(!(f.s & 0x80));
BRHC: SKIP(!(f.h & 0x10));
BRTC: SKIP(!S[S_T]);
BRID: SKIP(!S[S_I]);
JUMP: GO(i->n);
CALL:
    wide = PAIR(R_SPL); STACK(wide);
    PROFILED(if (i->d == 2 && i->k == (int32_t)PC + 2) goto SLOW;)
    wide = push_address(D, wide, (PC + i->d) / 2, avr->address_size);
    SET_PAIR(R_SPL, wide); target = i->n + avr->address_size;
    PROFILED(profile_jump(p, PC); SPEND(target); profile_called(h, (uint32_t)i->k);)
    i = AT(i->k); NEXT(target);
RET:
    wide = PAIR(R_SPL); STACK(wide + avr->address_size);
    if (!(wide = pop_address(avr, wide, &target)))
        goto SLOW;
    PROFILED(profile_jump(p, PC);)
    SET_PAIR(R_SPL, wide); i = AT(target);
    PROFILED(SPEND(2 + avr->address_size); profile_returned(h, target);)
    NEXT(2 + avr->address_size);
RETI:
    wide = PAIR(R_SPL); STACK(wide + avr->address_size);
    if (!(wide = pop_address(avr, wide, &target)))
        goto SLOW;
    PROFILED(profile_jump(p, PC);)
    SET_PAIR(R_SPL, wide); i = AT(target);
    enable(avr);
    end_interrupt(avr);
    PROFILED(SPEND(2 + avr->address_size); profile_returned(h, target); profile_mask(h, target);)
    ENABLED(2 + avr->address_size);
SEI:
    if (!enable(avr))
        DONE(1);
    PROFILED(SPEND(1); profile_mask(h, PC);)
    i++; ENABLED(1);
CLI:
    disable(avr);
    PROFILED(SPEND(0); profile_mask(h, PC);) DONE(1);
IJMP:
    if (i->d && !avr->eind)
        goto SLOW;
    target = (i->d ? (uint32_t)D[avr->eind] << 16 : 0) | PAIR(R_ZL);
    if (2 * target >= avr->flashend)
        goto SLOW;
    PROFILED(profile_jump(p, PC);)
    i = code + target; NEXT(2);
ICALL: wide = PAIR(R_SPL); STACK(wide); goto SLOW;
SLEEP:
    PROFILED(goto SLOW;)
    SPEND(1); pc = PC + 2;
    if (!avr->sreg[S_I] || !waiting(avr))
        avr->state = cpu_Sleeping;
    goto gone;
WDR:
    HANDLE(0);
    if (h->watchdog)
        h->watchdog->io.ioctl(&h->watchdog->io, AVR_IOCTL_WATCHDOG_RESET, NULL);
    HANDLED(PC + 2, 1);
ELPM: if (!avr->rampz || D[avr->rampz] > avr->flashend >> 16) goto wild; goto SLOW;
edge:       /* the stack is among the registers, or outside the memory */
    if (address > ram_end || address < 3)
        goto wild;
    goto SLOW;
WILD: wild:
    SPEND(0);
    crash(h, "access outside the memory");
    pc = PC;
    goto gone;
SLOW:
    flags_into(S, &f);
    SPEND(0);
    PROFILED(profile_count(h);)
    pc = leave_to_simavr(h, PC);
    if (!goes_on(h, pc, last))
        return pc;
    budget = left = budget_of(avr);
    i = AT(pc);
    f = flags_from(S);
    goto *labels[i->op];
handled:
    avr->cycle += target;
    if (!goes_on(h, pc, last))
        goto gone;
    budget = left = budget_of(avr);
    i = AT(pc);
    goto *labels[i->op];
PROFILED(crossed: SPEND(0); profile_cross(h, PC); goto *labels[i->op];)
out:        /* run timers that are due; the burst goes on unless they end it */
    SPEND(0);
    avr->pc = pc = PC;
    if (!h->profile)
        pass_timers(avr);
    if (goes_on(h, pc, last)) {
        budget = left = budget_of(avr);
        goto *labels[i->op];
    }
gone:
    flags_into(S, &f);
    PROFILED(profile_leave(h, pc);)
    return pc;
}
