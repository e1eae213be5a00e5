/* The processor's instructions, decoded once: what fast.c runs. */
#ifndef HEATWRIGHT_DECODE_H
#define HEATWRIGHT_DECODE_H

#include <stdint.h>

/* Rd, Rr: d, r. K: value. A: k (data address). T: k (target). n: cycles if taken or skipped. */
enum op {
    UNDECODED = 0, SLOW,
    NOP, MOVW, MULS, MUL, ADD, ADC, SUB, SBC, AND, OR, EOR, MOV, CP, CPC, CPSE,
    CPI, SBCI, SUBI, ORI, ANDI, LDI, ADIW, SBIW,
    COM, NEG, SWAP, INC, ASR, LSR, ROR, DEC, BSET, BCLR, BST, BLD,
    LDS, STS, LDD, STD, LD_INC, ST_INC, LD_DEC, ST_DEC, PUSH, POP, LPM, LPM_INC,
    IN_SREG, OUT_SREG, SBI, CBI, SBI_PIN, SBIC, SBIS, SBRC, SBRS,
    BRBS, BRBC, JUMP, CALL, RET
};

struct decoded {
    uint8_t op, d, r, n;
    int32_t k;
};

/* What the decoder has to know of a part. */
struct part {
    const uint8_t *flash;
    uint32_t flash_end;         /* last byte */
    const uint8_t *special;     /* of the first SPECIAL data addresses, see below */
};

#define SPECIAL 312             /* data addresses simavr may have handlers for */
enum { SPECIAL_READ = 1, SPECIAL_WRITE = 2, SPECIAL_PIN = 4 };

struct decoded decode(const struct part *part, uint32_t pc);

#endif
