/* The processor's core: instructions decoded once, run from a table.

   simavr decodes each instruction each time; this takes a third of its time. It does what simavr's
   core does, flag by flag and cycle by cycle (a test runs both on random code), and leaves to it
   what is rare or reaches a peripheral. Two things it does as the part does and simavr does not: SBI
   on a PIN register toggles that bit alone, and a skip over ADIW or SBIW skips one word. */
#include <stdlib.h>
#include <string.h>
#include "decode.h"
#include "hw.h"

struct fast {
    struct decoded *code;       /* one for each word of flash, and one beyond */
    uint8_t special[SPECIAL];
    struct part part;
};

#ifndef PROFILED
#define PROFILED(...)           /* what this file is for in profiled.c alone */

static void mark_special(hw *h) {
    uint8_t *special = h->fast->special;
    memset(special, 0, SPECIAL);
    for (int i = 0; i < MAX_IOs; i++) {
        int any = h->avr->io[i].irq != NULL;
        special[i + 32] = (uint8_t)((any || h->avr->io[i].r.c ? SPECIAL_READ : 0) |
                                    (any || h->avr->io[i].w.c ? SPECIAL_WRITE : 0));
    }
    special[R_SREG] = SPECIAL_READ | SPECIAL_WRITE;
    for (int i = 0; i < HW_PORTS; i++)
        if (h->ports[i].io)
            special[h->ports[i].io->r_pin] |= SPECIAL_PIN;
    if (h->profile)             /* for its lowest stack pointer */
        special[R_SPL] = special[R_SPH] = SPECIAL_WRITE;
}

/* Anew after the flash or the registers' handlers have changed. */
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
                                  .special = h->fast->special};
    h->fast->code[words].op = SLOW;
    fast_forget(h);
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

static inline void zns(uint8_t *S, uint8_t res) {
    S[S_Z] = res == 0;
    S[S_N] = res >> 7;
    S[S_S] = S[S_N] ^ S[S_V];
}

static inline void add_flags(uint8_t *S, uint8_t res, uint8_t a, uint8_t b) {
    uint8_t carry = (uint8_t)((a & b) | (b & ~res) | (~res & a));
    S[S_H] = BIT(carry, 3);
    S[S_C] = carry >> 7;
    S[S_V] = (uint8_t)((a & b & ~res) | (~a & ~b & res)) >> 7;
    zns(S, res);
}

/* keep: Z stays clear if it was (SBC, SBCI, CPC). */
static inline void sub_flags(uint8_t *S, uint8_t res, uint8_t a, uint8_t b, int keep) {
    uint8_t carry = (uint8_t)((~a & b) | (b & res) | (res & ~a)), zero = S[S_Z];
    S[S_H] = BIT(carry, 3);
    S[S_C] = carry >> 7;
    S[S_V] = (uint8_t)((a & ~b & ~res) | (~a & b & res)) >> 7;
    zns(S, res);
    if (keep)
        S[S_Z] &= zero;
}

static inline void logic_flags(uint8_t *S, uint8_t res) {
    S[S_V] = 0;
    zns(S, res);
}

static inline void shift_flags(uint8_t *S, uint8_t res, uint8_t before) {
    S[S_Z] = res == 0;
    S[S_C] = before & 1;
    S[S_N] = res >> 7;
    S[S_V] = S[S_N] ^ S[S_C];
    S[S_S] = S[S_N] ^ S[S_V];
}

static inline void word_flags(uint8_t *S, uint16_t res, uint16_t overflow, uint16_t carry) {
    S[S_V] = overflow >> 15;
    S[S_C] = carry >> 15;
    S[S_Z] = res == 0;
    S[S_N] = res >> 15;
    S[S_S] = S[S_N] ^ S[S_V];
}

static inline void product(uint8_t *D, uint8_t *S, uint16_t res) {
    SET_PAIR(0, res);
    S[S_Z] = res == 0;
    S[S_C] = res >> 15;
}

/* The eight flags, each a byte of 0 or 1, as one byte: the product moves them side by side. */
static inline uint8_t packed(const uint8_t *S) {
    uint64_t flags;
    memcpy(&flags, S, sizeof flags);
    return (uint8_t)(flags * 0x0102040810204080u >> 56);
}

static inline uint16_t push_address(uint8_t *D, uint16_t sp, uint32_t address, int size) {
    for (int n = 0; n < size; n++, address >>= 8)
        D[sp--] = (uint8_t)address;
    return sp;
}

/* The stack pointer after a return, and where to; 0 with a target beyond the flash. */
static inline uint16_t pop_address(avr_t *avr, uint16_t sp, uint32_t *target) {
    uint32_t back = 0;
    for (int n = 0; n < avr->address_size; n++)
        back = back << 8 | avr->data[++sp];
    *target = 2 * back;
    return 2 * back < avr->flashend ? sp : 0;
}

/* Interrupts come one instruction after I was set; the burst has to end for that. */
static inline int enable(avr_t *avr) {
    int change = !avr->sreg[S_I];
    if (change)
        avr->interrupt_state = -2;
    avr->sreg[S_I] = 1;
    return change;
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

/* simavr 1.6 takes ADIW and SBIW with K & 12 == 12 for instructions of two words: when it skips
   one, it goes a word too far, and takes a cycle too many. */
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
    avr->run_cycle_limit = avr->run_cycle_count = 1;    /* this one instruction */
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

/* The cycles up to now, and those of this instruction, reach avr->cycle before the burst ends. */
#define SPEND(cycles) \
    (avr->cycle += (uint32_t)(budget - left + (cycles)), budget = left - (int32_t)(cycles))

/* One instruction after the other: each label is an instruction, NEXT goes to the one after it. */
#define NEXT(cycles) do { \
        if ((left -= (int32_t)(cycles)) <= 0) \
            goto out; \
        PROFILED(if (pc - p->from >= p->size) goto crossed;) \
        i = &code[pc / 2]; \
        goto *labels[i->op]; \
    } while (0)
#define LEAVE(cycles) do { left -= (int32_t)(cycles); goto out; } while (0)
#define DONE(cycles) do { pc += 2; NEXT(cycles); } while (0)
#define SKIP(condition) do { \
        if (condition) { PROFILED(profile_jump(p, pc);) pc = (uint32_t)i->k; NEXT(i->n); } \
        DONE(1); \
    } while (0)
#define CHECK(a, how) do { \
        if ((a) > ram_end) \
            goto wild; \
        if ((a) < SPECIAL && (special[a] & (how))) \
            goto SLOW; \
    } while (0)
#define STACK(sp) do { \
        if ((sp) > ram_end || (sp) < 3) \
            goto wild; \
        if ((sp) < SPECIAL + 3) \
            goto SLOW; \
    } while (0)

/* Run until the next cycle timer, or until simavr has done an instruction. Returns the next pc. */
avr_flashaddr_t fast_run(hw *h) {
#define LABEL(name) &&name,
    static const void *const labels[] = {OPERATIONS(LABEL)};
    avr_t *const avr = h->avr;
    uint8_t *const D = avr->data, *const S = avr->sreg;
    struct decoded *const code = h->fast->code, *i;
    const uint8_t *const special = h->fast->special;
    const uint16_t ram_end = avr->ramend;
    int32_t budget = (int32_t)avr->run_cycle_count;
    int32_t left = budget;
    uint32_t pc = avr->pc;
    uint16_t address, wide;
    uint32_t target;
    uint8_t a, b, res;

    if (pc >= avr->flashend)
        return leave_to_simavr(h, pc);
    PROFILED(struct profile *const p = h->profile; profile_enter(h, pc); goto crossed;)
    i = &code[pc / 2];
    goto *labels[i->op];

UNDECODED:
    PROFILED(p->coverage[pc / 2] = 1;)
    *i = decode(&h->fast->part, pc); goto *labels[i->op];
NOP: DONE(1 + i->n);
MOVW: wide = PAIR(i->r); SET_PAIR(i->d, wide); DONE(1);
MULS: product(D, S, (uint16_t)((int8_t)Rd * (int8_t)Rr)); DONE(2);
MUL: product(D, S, (uint16_t)(Rd * Rr)); DONE(2);
ADD: a = Rd; b = Rr; Rd = res = (uint8_t)(a + b); add_flags(S, res, a, b); DONE(1);
ADC: a = Rd; b = Rr; Rd = res = (uint8_t)(a + b + S[S_C]); add_flags(S, res, a, b); DONE(1);
SUB: a = Rd; b = Rr; Rd = res = (uint8_t)(a - b); sub_flags(S, res, a, b, 0); DONE(1);
SBC: a = Rd; b = Rr; Rd = res = (uint8_t)(a - b - S[S_C]); sub_flags(S, res, a, b, 1); DONE(1);
CP: a = Rd; b = Rr; res = (uint8_t)(a - b); sub_flags(S, res, a, b, 0); DONE(1);
CPC: a = Rd; b = Rr; res = (uint8_t)(a - b - S[S_C]); sub_flags(S, res, a, b, 1); DONE(1);
CPI: a = Rd; b = K; res = (uint8_t)(a - b); sub_flags(S, res, a, b, 0); DONE(1);
SUBI: a = Rd; b = K; Rd = res = (uint8_t)(a - b); sub_flags(S, res, a, b, 0); DONE(1);
SBCI: a = Rd; b = K; Rd = res = (uint8_t)(a - b - S[S_C]); sub_flags(S, res, a, b, 1); DONE(1);
AND: Rd &= Rr; logic_flags(S, Rd); DONE(1);
OR: Rd |= Rr; logic_flags(S, Rd); DONE(1);
EOR: Rd ^= Rr; logic_flags(S, Rd); DONE(1);
ORI: Rd |= K; logic_flags(S, Rd); DONE(1);
ANDI: Rd &= K; logic_flags(S, Rd); DONE(1);
MOV: Rd = Rr; DONE(1);
LDI: Rd = K; DONE(1);
ADIW:
    address = PAIR(i->d); wide = (uint16_t)(address + i->k); SET_PAIR(i->d, wide);
    word_flags(S, wide, (uint16_t)(~address & wide), (uint16_t)(~wide & address)); DONE(2);
SBIW:
    address = PAIR(i->d); wide = (uint16_t)(address - i->k); SET_PAIR(i->d, wide);
    word_flags(S, wide, (uint16_t)(address & ~wide), (uint16_t)(wide & ~address)); DONE(2);
COM: Rd = (uint8_t)~Rd; logic_flags(S, Rd); S[S_C] = 1; DONE(1);
NEG:
    a = Rd; Rd = res = (uint8_t)-a;
    S[S_H] = BIT(res | a, 3); S[S_V] = res == 0x80; S[S_C] = res != 0; zns(S, res); DONE(1);
SWAP: Rd = (uint8_t)(Rd << 4 | Rd >> 4); DONE(1);
INC: res = ++Rd; S[S_V] = res == 0x80; zns(S, res); DONE(1);
DEC: res = --Rd; S[S_V] = res == 0x7f; zns(S, res); DONE(1);
ASR: a = Rd; Rd = res = (uint8_t)(a >> 1 | (a & 0x80)); shift_flags(S, res, a); DONE(1);
LSR: a = Rd; Rd = res = a >> 1; shift_flags(S, res, a); DONE(1);
ROR: a = Rd; Rd = res = (uint8_t)(a >> 1 | S[S_C] << 7); shift_flags(S, res, a); DONE(1);
BSET: S[i->d] = 1; DONE(1);
BCLR: S[i->d] = 0; DONE(1);
BST: S[S_T] = BIT(Rd, i->r); DONE(1);
BLD: Rd = (uint8_t)(S[S_T] ? Rd | i->r : Rd & ~i->r); DONE(1);
LDS: if (i->k > ram_end) goto wild; Rd = D[i->k]; pc += 2; DONE(2);
STS: if (i->k > ram_end) goto wild; D[i->k] = Rd; pc += 2; DONE(2);
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
PUSH:
    wide = PAIR(R_SPL); STACK(wide); D[wide] = Rd; SET_PAIR(R_SPL, wide - 1);
    PROFILED(profile_stack(p, (uint16_t)(wide - 1));) DONE(2);
POP: wide = PAIR(R_SPL); STACK(wide + 1); SET_PAIR(R_SPL, wide + 1); Rd = D[wide + 1]; DONE(2);
LPM: Rd = avr->flash[PAIR(R_ZL) & avr->flashend]; DONE(3);
LPM_INC: wide = PAIR(R_ZL); a = avr->flash[wide & avr->flashend]; Rd = a; SET_PAIR(R_ZL, wide + 1); DONE(3);
IN_SREG: Rd = D[R_SREG] = packed(S); DONE(1);
OUT_SREG:
    a = D[R_SREG] = Rd;
    for (int n = 0; n < S_I; n++)
        S[n] = BIT(a, n);
    if (!(a >> 7)) {
        disable(avr);
        PROFILED(SPEND(0); profile_mask(h, pc);)
    } else if (enable(avr)) {
        PROFILED(SPEND(1); profile_mask(h, pc);)
        pc += 2;
        LEAVE(1);
    }
    DONE(1);
SBI: Rd |= i->r; DONE(2);
CBI: Rd &= (uint8_t)~i->r; DONE(2);
SBI_PIN: SPEND(0); pc = toggle(avr, pc, i->d, i->r); goto gone;
SBRC: SKIP(!(Rd & i->r));
SBRS: SKIP(Rd & i->r);
CPSE: SKIP(Rd == Rr);
BRBS: SKIP(S[i->d]);
BRBC: SKIP(!S[i->d]);
JUMP: PROFILED(profile_jump(p, pc);) pc = (uint32_t)i->k; NEXT(i->n);
CALL:
    wide = PAIR(R_SPL); STACK(wide);
    PROFILED(if (i->d == 2 && i->k == (int32_t)pc + 2) goto SLOW; profile_jump(p, pc);)
    wide = push_address(D, wide, (pc + i->d) / 2, avr->address_size);
    SET_PAIR(R_SPL, wide); pc = (uint32_t)i->k;
    PROFILED(SPEND(i->n + avr->address_size); profile_called(h, pc);)
    NEXT(i->n + avr->address_size);
RET:
    wide = PAIR(R_SPL); STACK(wide + avr->address_size);
    if (!(wide = pop_address(avr, wide, &target)))
        goto SLOW;
    PROFILED(profile_jump(p, pc);)
    SET_PAIR(R_SPL, wide); pc = target;
    PROFILED(SPEND(2 + avr->address_size); profile_returned(h, pc);)
    NEXT(2 + avr->address_size);
RETI:
    wide = PAIR(R_SPL); STACK(wide + avr->address_size);
    if (!(wide = pop_address(avr, wide, &target)))
        goto SLOW;
    PROFILED(profile_jump(p, pc);)
    SET_PAIR(R_SPL, wide); pc = target;
    enable(avr);
    avr_interrupt_reti(avr);
    PROFILED(SPEND(2 + avr->address_size); profile_returned(h, pc); profile_mask(h, pc);)
    LEAVE(2 + avr->address_size);
SEI:
    if (!enable(avr))
        DONE(1);
    PROFILED(SPEND(1); profile_mask(h, pc);)
    pc += 2; LEAVE(1);
CLI:
    disable(avr);
    PROFILED(SPEND(0); profile_mask(h, pc);) DONE(1);
IJMP:
    if (i->d && !avr->eind)
        goto SLOW;
    target = (i->d ? (uint32_t)D[avr->eind] << 16 : 0) | PAIR(R_ZL);
    if (2 * target >= avr->flashend)
        goto SLOW;
    PROFILED(profile_jump(p, pc);)
    pc = 2 * target; NEXT(2);
ICALL: wide = PAIR(R_SPL); STACK(wide); goto SLOW;
ELPM: if (!avr->rampz || D[avr->rampz] > avr->flashend >> 16) goto wild; goto SLOW;
wild:
    SPEND(0);
    crash(h, "access outside the memory");
    goto gone;
SLOW:
    SPEND(0);
    PROFILED(profile_count(h);)
    return leave_to_simavr(h, pc);
PROFILED(crossed: SPEND(0); profile_cross(h, pc); i = &code[pc / 2]; goto *labels[i->op];)
out:
    SPEND(0);
gone:
    PROFILED(profile_leave(h, pc);)
    return pc;
}
