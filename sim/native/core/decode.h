/* The processor's instructions, decoded once: what fast.c runs. */
#pragma once

#include <stdint.h>

/* Fields of a decoded instruction: d, r: registers (or an I/O address and a mask); k: a value, data
   address or target; n: the cycles when taken or skipped, the first register of a pointer, or the
   number of equal instructions in a row. */
#define OPERATIONS(X) \
    X(UNDECODED) X(SLOW) X(NOP) X(MOVW) X(MULS) X(MUL) X(ADD) X(ADC) X(SUB) X(SBC) X(AND) X(OR) \
    X(EOR) X(MOV) X(CP) X(CPC) X(CPSE) X(CPI) X(SBCI) X(SUBI) X(ORI) X(ANDI) X(LDI) X(ADIW) \
    X(SBIW) X(COM) X(NEG) X(SWAP) X(INC) X(ASR) X(LSR) X(ROR) X(DEC) X(BSET) X(BCLR) X(BST) \
    X(BLD) X(LDS) X(STS) X(IN) X(OUT) X(LDD) X(STD) X(LD_INC) X(ST_INC) X(LD_DEC) X(ST_DEC) \
    X(PUSH) X(POP) X(LPM) X(LPM_INC) X(IN_SREG) X(OUT_SREG) X(SBI) X(CBI) X(SBI_PIN) X(SBI_PORT) \
    X(CBI_PORT) X(SBI_IO) X(CBI_IO) X(SBIC_IO) X(SBIS_IO) X(IN_IO) X(OUT_IO) X(LDS_IO) X(STS_IO) \
    X(SBRC) X(SBRS) X(BRCS) X(BREQ) X(BRMI) X(BRVS) X(BRLT) X(BRHS) X(BRTS) X(BRIE) \
    X(BRCC) X(BRNE) X(BRPL) X(BRVC) X(BRGE) X(BRHC) X(BRTC) X(BRID) X(JUMP) X(CALL) X(RET) X(RETI) \
    X(SEI) X(CLI) X(IJMP) X(ICALL) X(ELPM) X(DELAY) X(SLEEP) X(WDR) X(WILD) X(MARKED)

#define NAME(name) name,
enum op { OPERATIONS(NAME) };

struct decoded {
    uint8_t op, d, r, n;
    int32_t k;
};

/* The properties of a part that the decoder needs. */
struct part {
    const uint8_t *flash;
    uint32_t flash_end, ram_end;        /* last bytes */
    const uint8_t *special;     /* for the first SPECIAL data addresses, see below */
};

#define SPECIAL 312             /* data addresses for which simavr may have handlers */
#define LEAST_STACK (SPECIAL + 3)       /* a stack above this address pushes to plain memory */
enum { SPECIAL_READ = 1, SPECIAL_WRITE = 2, SPECIAL_PIN = 4, SPECIAL_PORT = 8, SPECIAL_PROFILED = 16 };

struct decoded decode(const struct part *part, uint32_t pc);
