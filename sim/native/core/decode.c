/* Decode one instruction (AVR instruction set manual). Rare ones are left to simavr: SLOW. */
#include <simavr/sim_avr.h>
#include "decode.h"

static uint16_t word(const struct part *p, uint32_t pc) {
    return pc < p->flash_end ? (uint16_t)(p->flash[pc] | p->flash[pc + 1] << 8) : 0;
}

/* LDS, STS, JMP, CALL: these have two words. */
static int is_long(uint16_t op) {
    op &= 0xfe0f;
    return op == 0x9200 || op == 0x9000 || (op & 0xfffc) == 0x940c;
}

static int special(const struct part *p, uint32_t address, int how) {
    return address < SPECIAL && (p->special[address] & how);
}

/* Whether our core itself calls a register's handlers; a profile leaves them to simavr. */
static int handled(const struct part *p, uint32_t address) {
    return address != R_SREG && !(p->special[address] & SPECIAL_PROFILED);
}

static struct decoded make(int op, int d, int r, int32_t k) {
    return (struct decoded){.op = (uint8_t)op, .d = (uint8_t)d, .r = (uint8_t)r, .k = k};
}

static struct decoded slow(void) { return make(SLOW, 0, 0, 0); }

static struct decoded two_registers(int op, uint16_t o) {
    return make(op, o >> 4 & 31, (o >> 5 & 16) | (o & 15), 0);
}

static struct decoded immediate(int op, uint16_t o) {
    return make(op, 16 + (o >> 4 & 15), 0, (o >> 4 & 0xf0) | (o & 15));
}

/* n: cycles without those that push the return address; d: bytes of the instruction. */
static struct decoded jump(const struct part *p, int op, int64_t target, int words) {
    if (target < 0 || target >= p->flash_end)
        return slow();
    struct decoded i = make(op, 2 * words, 0, (int32_t)target);
    i.n = (uint8_t)(op == CALL ? words : words + 1);
    return i;
}

/* Add the target and the cycles of a skip; d and r are already set. */
static struct decoded skip(const struct part *p, struct decoded i, uint32_t pc) {
    int more = is_long(word(p, pc + 2));
    if (pc + 4 + 2u * (unsigned)more >= p->flash_end)
        return slow();
    i.k = (int32_t)(pc + 4 + 2u * (unsigned)more);
    i.n = (uint8_t)(2 + more);
    return i;
}

static struct decoded low_page(uint16_t o) {
    static const uint8_t ops[] = {0, CPC, SBC, ADD};
    if (o >> 10)
        return two_registers(ops[o >> 10], o);
    if (!o)
        return make(NOP, 0, 0, 0);
    if (o >> 8 == 1)
        return make(MOVW, (o >> 4 & 15) * 2, (o & 15) * 2, 0);
    if (o >> 8 == 2)
        return make(MULS, 16 + (o >> 4 & 15), 16 + (o & 15), 0);
    return slow();
}

/* LDD and STD: n is the pointer's first register. */
static struct decoded displaced(uint16_t o) {
    struct decoded i = make(o & 0x200 ? STD : LDD, o >> 4 & 31, 0, 0);
    i.n = o & 8 ? R_YL : R_ZL;
    i.k = (o >> 8 & 0x20) | (o >> 7 & 0x18) | (o & 7);
    return i;
}

static struct decoded direct(const struct part *p, uint16_t o, uint32_t pc) {
    int store = o & 0x200;
    uint16_t address = word(p, pc + 2);
    if (pc + 4 >= p->flash_end)
        return slow();
    if (address > p->ram_end)
        return make(WILD, 0, 0, 0);
    if (!special(p, address, store ? SPECIAL_WRITE : SPECIAL_READ))
        return make(store ? STS : LDS, o >> 4 & 31, 0, address);
    return handled(p, address) ? make(store ? STS_IO : LDS_IO, o >> 4 & 31, 0, address) : slow();
}

/* PUSH or POP, with the number of such instructions in a row, this one included. */
static struct decoded in_row(const struct part *p, struct decoded i, uint16_t o, uint32_t pc) {
    enum { MOST = 32 };
    while (i.n < MOST && (word(p, pc + 2u * i.n) & 0xfe0f) == (o & 0xfe0f))
        i.n++;
    return i;
}

/* 1001 00sd dddd xxxx: loads and stores through pointers, stack, flash. */
static struct decoded indirect(const struct part *p, uint16_t o, uint32_t pc) {
    int store = o & 0x200, how = o & 15, d = o >> 4 & 31;
    struct decoded i = make(SLOW, d, 0, 0);
    if (how == 0)
        return direct(p, o, pc);
    if (how == 15)
        return in_row(p, make(store ? PUSH : POP, d, 0, 0), o, pc);
    if (how == 4 || how == 5)
        return make(store ? SLOW : how == 4 ? LPM : LPM_INC, d, 0, 0);
    i.n = how >= 12 ? R_XL : how >= 8 ? R_YL : R_ZL;
    if ((how & 3) == 1)
        i.op = store ? ST_INC : LD_INC;
    else if ((how & 3) == 2)
        i.op = store ? ST_DEC : LD_DEC;
    else if (how == 12)
        i.op = store ? STD : LDD;
    if (how == 6 || how == 7)
        i.op = store ? SLOW : ELPM;
    return i;
}

/* 1001 010x: one register, flags, jumps. */
static struct decoded single(const struct part *p, uint16_t o, uint32_t pc) {
    static const uint8_t ops[] = {COM, NEG, SWAP, INC, SLOW, ASR, LSR, ROR,
                                  SLOW, SLOW, DEC, SLOW, SLOW, SLOW, SLOW, SLOW};
    uint32_t far = (uint32_t)((o >> 3 & 0x3e) | (o & 1)) << 16 | word(p, pc + 2);
    if ((o & 0xfe0c) == 0x940c)
        return jump(p, o & 2 ? CALL : JUMP, 2 * (int64_t)far, 2);
    if (o == 0x9508 || o == 0x9518)
        return make(o == 0x9508 ? RET : RETI, 0, 0, 0);
    if (o == 0x9509 || o == 0x9519 || o == 0x95d8)
        return make(o == 0x95d8 ? ELPM : ICALL, 0, 0, 0);
    if (o == 0x9478 || o == 0x94f8)
        return make(o == 0x9478 ? SEI : CLI, 0, 0, 0);
    if (o == 0x9588 || o == 0x95a8)
        return make(o == 0x9588 ? SLEEP : WDR, 0, 0, 0);
    if (o == 0x9409)
        return make(IJMP, 0, 0, 0);
    if (o == 0x9419)
        return make(IJMP, 1, 0, 0);
    if ((o & 0xff0f) == 0x9408)
        return make(o & 0x80 ? BCLR : BSET, o >> 4 & 7, 0, 0);
    if ((o & 15) == 10 && word(p, pc + 2) == 0xf7f1)    /* BRNE to this DEC: a loop that waits */
        return make(DELAY, o >> 4 & 31, 0, 0);
    return make(ops[o & 15], o >> 4 & 31, 0, 0);
}

/* 1001 10xx: single bits of I/O registers. */
static struct decoded io_bit(const struct part *p, uint16_t o, uint32_t pc) {
    int address = 32 + (o >> 3 & 31), mask = 1 << (o & 7), kind = o >> 8 & 3;
    struct decoded i = make(SLOW, address, mask, 0);
    if (kind == 0 || kind == 2) {
        int pin = p->special[address] & SPECIAL_PIN;
        int port = p->special[address] & SPECIAL_PORT;
        i.op = pin ? kind ? SBI_PIN : NOP : port ? kind ? SBI_PORT : CBI_PORT
             : !special(p, (uint32_t)address, 3) ? kind ? SBI : CBI
             : !handled(p, (uint32_t)address) ? SLOW : kind ? SBI_IO : CBI_IO;
        i.n = pin && !kind;
        return i;
    }
    i.op = !special(p, (uint32_t)address, SPECIAL_READ) ? kind == 3 ? SBRS : SBRC
         : !handled(p, (uint32_t)address) ? SLOW : kind == 3 ? SBIS_IO : SBIC_IO;
    return i.op == SLOW ? i : skip(p, i, pc);
}

static struct decoded word_immediate(uint16_t o) {
    return make(o & 0x100 ? SBIW : ADIW, 24 + (o >> 3 & 6), 0, (o >> 2 & 0x30) | (o & 15));
}

static struct decoded page_nine(const struct part *p, uint16_t o, uint32_t pc) {
    switch (o >> 10 & 3) {
        case 0: return indirect(p, o, pc);
        case 1: return (o & 0x200) ? word_immediate(o) : single(p, o, pc);
        case 2: return io_bit(p, o, pc);
        default: return two_registers(MUL, o);
    }
}

static struct decoded in_out(const struct part *p, uint16_t o) {
    int out = o & 0x800, d = o >> 4 & 31;
    uint32_t address = 32u + (unsigned)((o >> 5 & 0x30) | (o & 15));
    if (address == R_SREG)
        return make(out ? OUT_SREG : IN_SREG, d, 0, 0);
    if (!special(p, address, out ? SPECIAL_WRITE : SPECIAL_READ))
        return make(out ? OUT : IN, d, 0, (int32_t)address);
    return handled(p, address) ? make(out ? OUT_IO : IN_IO, d, 0, (int32_t)address) : slow();
}

static struct decoded page_fifteen(const struct part *p, uint16_t o, uint32_t pc) {
    int d = o >> 4 & 31, bit = o & 7;
    int32_t offset = (int16_t)(uint16_t)(o << 6) >> 9;
    switch (o >> 9 & 7) {
        case 0: case 1: case 2: case 3:
            return jump(p, (o & 0x400 ? BRCC : BRCS) + bit, (int64_t)pc + 2 + 2 * offset, 1);
        case 4: return make(BLD, d, 1 << bit, 0);
        case 5: return make(BST, d, bit, 0);
        case 6: return skip(p, make(SBRC, d, 1 << bit, 0), pc);
        default: return skip(p, make(SBRS, d, 1 << bit, 0), pc);
    }
}

static struct decoded relative(const struct part *p, int op, uint16_t o, uint32_t pc) {
    int32_t offset = (int16_t)(uint16_t)(o << 4) >> 3;
    return jump(p, op, ((int64_t)pc + 2 + offset) & p->flash_end, 1);
}

struct decoded decode(const struct part *p, uint32_t pc) {
    static const uint8_t one[] = {CPSE, CP, SUB, ADC}, two[] = {AND, EOR, OR, MOV};
    uint16_t o = word(p, pc);
    switch (o >> 12) {
        case 0: return low_page(o);
        case 1:
            if (o >> 10 == 4)
                return skip(p, two_registers(CPSE, o), pc);
            return two_registers(one[o >> 10 & 3], o);
        case 2: return two_registers(two[o >> 10 & 3], o);
        case 3: return immediate(CPI, o);
        case 4: return immediate(SBCI, o);
        case 5: return immediate(SUBI, o);
        case 6: return immediate(ORI, o);
        case 7: return immediate(ANDI, o);
        case 8: case 10: return displaced(o);
        case 9: return page_nine(p, o, pc);
        case 11: return in_out(p, o);
        case 12: return relative(p, JUMP, o, pc);
        case 13: return relative(p, CALL, o, pc);
        case 14: return immediate(LDI, o);
        default: return page_fifteen(p, o, pc);
    }
}
