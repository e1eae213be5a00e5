/* The processor's core: instructions decoded once, run from a table.

   simavr decodes each instruction each time; this takes a third of its time. It does what simavr's
   core does, flag by flag and cycle by cycle (a test runs both on random code), and leaves to it
   what is rare or reaches a peripheral. One thing it does as the part does and simavr does not: SBI
   on a PIN register toggles that bit alone. */
#include <stdlib.h>
#include <string.h>
#include "decode.h"
#include "hw.h"

struct fast {
    struct decoded *code;       /* one for each word of flash, and one beyond */
    uint8_t special[SPECIAL];
    struct part part;
};

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

#define Rd (D[i->d])
#define Rr (D[i->r])
#define PAIR(n) ((uint16_t)(D[n] | D[(n) + 1] << 8))
#define SET_PAIR(n, v) (D[n] = (uint8_t)(v), D[(n) + 1] = (uint8_t)((v) >> 8))
#define BIT(v, n) ((uint8_t)((v) >> (n) & 1))

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

static avr_flashaddr_t leave_to_simavr(hw *h, uint32_t pc) {
    avr_t *avr = h->avr;
    int writes_flash = pc < avr->flashend && avr->flash[pc] == 0xe8 && avr->flash[pc + 1] == 0x95;
    avr->pc = pc;
    avr->run_cycle_limit = avr->run_cycle_count = 1;    /* this one instruction */
    pc = avr_run_one(avr);
    if (writes_flash)
        fast_forget(h);
    return pc;
}

static avr_flashaddr_t toggle(avr_t *avr, uint32_t pc, uint8_t address, uint8_t mask) {
    avr_io_addr_t a = AVR_DATA_TO_IO(address);
    avr->pc = pc;
    avr->io[a].w.c(avr, address, mask, avr->io[a].w.param);
    avr->cycle += 2;
    return pc + 2;
}

/* Run until the next cycle timer, or until simavr has done an instruction. Returns the next pc. */
avr_flashaddr_t fast_run(hw *h) {
    avr_t *avr = h->avr;
    uint8_t *D = avr->data, *S = avr->sreg;
    struct decoded *code = h->fast->code;
    const uint8_t *special = h->fast->special;
    const uint16_t ram_end = avr->ramend;
    uint32_t pc = avr->pc, used = 0, cost;
    uint32_t left = (uint32_t)avr->run_cycle_count;

#define LEAVE goto leave
#define CHECK(a, how) \
    if ((a) > ram_end || ((a) < SPECIAL && (special[a] & (how)))) LEAVE
#define STACK(sp) if ((sp) > ram_end || (sp) < SPECIAL + 3) LEAVE

    if (pc >= avr->flashend)
        return leave_to_simavr(h, pc);
    for (;;) {
        struct decoded *i = &code[pc / 2];
        uint8_t res, a, b;
        uint16_t address, wide;
    again:
        cost = 1;
        switch (i->op) {
        case UNDECODED:
            *i = decode(&h->fast->part, pc);
            goto again;
        case SLOW: LEAVE;
        case NOP: cost += i->n; pc += 2; break;
        case MOVW: wide = PAIR(i->r); SET_PAIR(i->d, wide); pc += 2; break;
        case MULS: product(D, S, (uint16_t)((int8_t)Rd * (int8_t)Rr)); cost = 2; pc += 2; break;
        case MUL: product(D, S, (uint16_t)(Rd * Rr)); cost = 2; pc += 2; break;
        case ADD: a = Rd; b = Rr; Rd = res = (uint8_t)(a + b); add_flags(S, res, a, b); pc += 2; break;
        case ADC: a = Rd; b = Rr; Rd = res = (uint8_t)(a + b + S[S_C]); add_flags(S, res, a, b); pc += 2; break;
        case SUB: a = Rd; b = Rr; Rd = res = (uint8_t)(a - b); sub_flags(S, res, a, b, 0); pc += 2; break;
        case SBC: a = Rd; b = Rr; Rd = res = (uint8_t)(a - b - S[S_C]); sub_flags(S, res, a, b, 1); pc += 2; break;
        case CP: a = Rd; b = Rr; res = (uint8_t)(a - b); sub_flags(S, res, a, b, 0); pc += 2; break;
        case CPC: a = Rd; b = Rr; res = (uint8_t)(a - b - S[S_C]); sub_flags(S, res, a, b, 1); pc += 2; break;
        case CPI: a = Rd; b = (uint8_t)i->k; res = (uint8_t)(a - b); sub_flags(S, res, a, b, 0); pc += 2; break;
        case SUBI: a = Rd; b = (uint8_t)i->k; Rd = res = (uint8_t)(a - b); sub_flags(S, res, a, b, 0); pc += 2; break;
        case SBCI: a = Rd; b = (uint8_t)i->k; Rd = res = (uint8_t)(a - b - S[S_C]); sub_flags(S, res, a, b, 1); pc += 2; break;
        case AND: Rd &= Rr; logic_flags(S, Rd); pc += 2; break;
        case OR: Rd |= Rr; logic_flags(S, Rd); pc += 2; break;
        case EOR: Rd ^= Rr; logic_flags(S, Rd); pc += 2; break;
        case ORI: Rd |= (uint8_t)i->k; logic_flags(S, Rd); pc += 2; break;
        case ANDI: Rd &= (uint8_t)i->k; logic_flags(S, Rd); pc += 2; break;
        case MOV: Rd = Rr; pc += 2; break;
        case LDI: Rd = (uint8_t)i->k; pc += 2; break;
        case ADIW:
            wide = (uint16_t)(PAIR(i->d) + i->k);
            word_flags(S, wide, (uint16_t)(~PAIR(i->d) & wide), (uint16_t)(~wide & PAIR(i->d)));
            SET_PAIR(i->d, wide); cost = 2; pc += 2; break;
        case SBIW:
            wide = (uint16_t)(PAIR(i->d) - i->k);
            word_flags(S, wide, (uint16_t)(PAIR(i->d) & ~wide), (uint16_t)(wide & ~PAIR(i->d)));
            SET_PAIR(i->d, wide); cost = 2; pc += 2; break;
        case COM: Rd = (uint8_t)~Rd; logic_flags(S, Rd); S[S_C] = 1; pc += 2; break;
        case NEG:
            a = Rd; Rd = res = (uint8_t)-a;
            S[S_H] = BIT(res | a, 3); S[S_V] = res == 0x80; S[S_C] = res != 0; zns(S, res);
            pc += 2; break;
        case SWAP: Rd = (uint8_t)(Rd << 4 | Rd >> 4); pc += 2; break;
        case INC: Rd++; S[S_V] = Rd == 0x80; zns(S, Rd); pc += 2; break;
        case DEC: Rd--; S[S_V] = Rd == 0x7f; zns(S, Rd); pc += 2; break;
        case ASR: a = Rd; Rd = (uint8_t)(a >> 1 | (a & 0x80)); shift_flags(S, Rd, a); pc += 2; break;
        case LSR: a = Rd; Rd = a >> 1; shift_flags(S, Rd, a); pc += 2; break;
        case ROR: a = Rd; Rd = (uint8_t)(a >> 1 | S[S_C] << 7); shift_flags(S, Rd, a); pc += 2; break;
        case BSET: S[i->d] = 1; pc += 2; break;
        case BCLR: S[i->d] = 0; pc += 2; break;
        case BST: S[S_T] = BIT(Rd, i->r); pc += 2; break;
        case BLD: Rd = (uint8_t)(S[S_T] ? Rd | i->r : Rd & ~i->r); pc += 2; break;
        case LDS:
            if (i->k > ram_end) LEAVE;
            Rd = D[i->k]; cost = 2 - i->n; pc += 4 - 2u * i->n; break;
        case STS:
            if (i->k > ram_end) LEAVE;
            D[i->k] = Rd; cost = 2 - i->n; pc += 4 - 2u * i->n; break;
        case LDD: address = (uint16_t)(PAIR(i->n) + i->k); CHECK(address, SPECIAL_READ); Rd = D[address]; cost = 2; pc += 2; break;
        case STD: address = (uint16_t)(PAIR(i->n) + i->k); CHECK(address, SPECIAL_WRITE); D[address] = Rd; cost = 2; pc += 2; break;
        case LD_INC: address = PAIR(i->n); CHECK(address, SPECIAL_READ); a = D[address]; SET_PAIR(i->n, address + 1); Rd = a; cost = 2; pc += 2; break;
        case ST_INC: address = PAIR(i->n); CHECK(address, SPECIAL_WRITE); D[address] = Rd; SET_PAIR(i->n, address + 1); cost = 2; pc += 2; break;
        case LD_DEC: address = (uint16_t)(PAIR(i->n) - 1); CHECK(address, SPECIAL_READ); a = D[address]; SET_PAIR(i->n, address); Rd = a; cost = 2; pc += 2; break;
        case ST_DEC: address = (uint16_t)(PAIR(i->n) - 1); CHECK(address, SPECIAL_WRITE); D[address] = Rd; SET_PAIR(i->n, address); cost = 2; pc += 2; break;
        case PUSH: wide = PAIR(R_SPL); STACK(wide); D[wide] = Rd; SET_PAIR(R_SPL, wide - 1); cost = 2; pc += 2; break;
        case POP: wide = PAIR(R_SPL); STACK(wide + 1); SET_PAIR(R_SPL, wide + 1); Rd = D[wide + 1]; cost = 2; pc += 2; break;
        case LPM: Rd = avr->flash[PAIR(R_ZL) & avr->flashend]; cost = 3; pc += 2; break;
        case LPM_INC: wide = PAIR(R_ZL); Rd = avr->flash[wide & avr->flashend]; SET_PAIR(R_ZL, wide + 1); cost = 3; pc += 2; break;
        case IN_SREG: Rd = D[R_SREG] = packed(S); pc += 2; break;
        case OUT_SREG:
            a = Rd;
            if (a >> 7 != S[S_I]) LEAVE;
            for (int n = 0; n < 8; n++) S[n] = BIT(a, n);
            D[R_SREG] = a; pc += 2; break;
        case SBI: Rd |= i->r; cost = 2; pc += 2; break;
        case CBI: Rd &= (uint8_t)~i->r; cost = 2; pc += 2; break;
        case SBI_PIN: avr->cycle += used; return toggle(avr, pc, i->d, i->r);
        case SBRC: case SBIC: if (Rd & i->r) pc += 2; else { cost = i->n; pc = (uint32_t)i->k; } break;
        case SBRS: case SBIS: if (!(Rd & i->r)) pc += 2; else { cost = i->n; pc = (uint32_t)i->k; } break;
        case CPSE: if (Rd != Rr) pc += 2; else { cost = i->n; pc = (uint32_t)i->k; } break;
        case BRBS: if (!S[i->d]) pc += 2; else { cost = 2; pc = (uint32_t)i->k; } break;
        case BRBC: if (S[i->d]) pc += 2; else { cost = 2; pc = (uint32_t)i->k; } break;
        case JUMP: cost = 3 - i->n; pc = (uint32_t)i->k; break;
        case CALL: {
            uint32_t back = (pc + 4 - 2u * i->n) / 2;
            wide = PAIR(R_SPL); STACK(wide);
            for (int n = 0; n < avr->address_size; n++, back >>= 8) D[wide--] = (uint8_t)back;
            SET_PAIR(R_SPL, wide);
            cost = 2u + avr->address_size - i->n; pc = (uint32_t)i->k; break;
        }
        case RET: {
            uint32_t back = 0;
            wide = PAIR(R_SPL); STACK(wide + avr->address_size);
            for (int n = 0; n < avr->address_size; n++) back = back << 8 | D[++wide];
            if (2 * back >= avr->flashend) LEAVE;
            SET_PAIR(R_SPL, wide);
            cost = 2u + avr->address_size; pc = 2 * back; break;
        }
        default: LEAVE;
        }
        used += cost;
        if (left <= cost) {
            avr->cycle += used;
            return pc;
        }
        left -= cost;
    }
leave:
    avr->cycle += used;
    return leave_to_simavr(h, pc);
}
