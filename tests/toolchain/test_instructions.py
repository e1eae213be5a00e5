"""The decoder agrees with the disassembler on every word of a large program."""

import re
import subprocess

import pytest
from elftools.elf.elffile import ELFFile
from rig.avr import compiled

from heatwright.generator.stack.instructions import Instruction, decode

# fmt: off
SAME = {
    "adc", "add", "adiw", "call", "eor", "icall", "ijmp", "in", "jmp", "ldi", "mov", "movw", "out",
    "pop", "push", "ret", "sbc", "sbci", "sbiw", "sei", "sub", "subi",
}
FOLLOWED = {name: name for name in SAME} | {
    "rcall": "call", "rjmp": "jmp", "reti": "ret", "eijmp": "ijmp", "eicall": "icall",
    "cpse": "skip", "sbrc": "skip", "sbrs": "skip", "sbic": "skip", "sbis": "skip",
}
# fmt: on

STORES = {"st", "std", "sts"}
READS = {"bst", "cbi", "cli", "clt", "cp", "cpc", "cpi", "nop", "sbi", "sec", "set", "sei", "sleep"}
POINTERS = {"X": 26, "Y": 28, "Z": 30}

# Address, words, mnemonic, operands, and the address that a jump or call goes to.
LINE = re.compile(
    r"^ +([0-9a-f]+):\t((?:[0-9a-f]{2} )+) *\t(\w+)\t?([^;\n]*?)\s*(?:; 0x([0-9a-f]+).*)?(?:;.*)?$",
    re.MULTILINE,
)

PROGRAM = """
#include <math.h>
#include <stdio.h>
volatile double x; volatile int64_t y; volatile char text[30]; void (*volatile f)(int, ...);
__attribute__((noinline)) char choose(char n, const char *p)
{
    switch (n) {
    case 0: return PINB; case 1: return PINC; case 2: return 9; case 3: PORTC = 4; return 7;
    case 4: return PIND; case 5: PORTB = 1; return 3; case 6: return pgm_read_byte(p);
    case 7: return 1;
    }
    return 0;
}
int main(void)
{
    volatile char frame[300];
    for (;;) {
        x = sin(x) + atan2(x, 3) + pow(x, x) + sqrt(x) / exp(x);
        y = y / 3 * y % 7;
        sprintf((char *)text, "%d %d", (int)y, choose(PINB, (const char *)PINC));
        if (PINB & 4) PORTB ^= 2;
        f(PINC, frame[PIND], frame);
    }
}
"""


def listing(mcu: str) -> tuple[bytes, str]:
    """Return the program's machine code, and what the disassembler says of it."""
    elf = compiled(PROGRAM, "-lm", mcu=mcu).path
    with elf.open("rb") as file:
        code: bytes = ELFFile(file).get_section_by_name(".text").data()
    words = ["avr-objdump", "-d", str(elf)]
    return code, subprocess.run(words, capture_output=True, text=True, check=True).stdout


def changed(mnemonic: str, operands: str) -> set[int]:
    """Registers that an instruction changes, by the manual."""
    if "mul" in mnemonic:
        return {0, 1}
    moved = re.search(r"([XYZ])\+(?!\d)|-([XYZ])", operands)
    found = set()
    if moved:
        pointer = POINTERS[moved.group(1) or moved.group(2)]
        found = {pointer, pointer + 1}
    if mnemonic in STORES | READS or mnemonic.startswith("br"):
        return found
    first = re.match(r"r(\d+)", operands)
    return found | ({int(first.group(1))} if first else set())


def check_operands(found: Instruction, mnemonic: str, operands: str, target: str) -> None:
    if found.name in ("call", "jmp", "branch"):
        assert found.k % 2**32 == int(target, 16)  # a table read as code leads anywhere
    elif found.name == "other":
        assert set(found.writes) >= changed(mnemonic, operands)
    elif found.name != "skip":
        registers = [int(number) for number in re.findall(r"\br(\d+)", operands)]
        constants = [int(number, 16) for number in re.findall(r"0x([0-9A-Fa-f]+)", operands)]
        assert registers == [found.d, found.r][: len(registers)]
        assert constants == [found.k][: len(constants)]


@pytest.mark.parametrize("mcu", ["atmega328p", "atmega2560"])
def test_the_decoder_agrees_with_the_disassembler(mcu: str) -> None:
    code, text = listing(mcu)
    lines = LINE.findall(text)
    assert len(lines) > 2400
    seen = set()
    for address, words, mnemonic, operands, target in lines:
        if mnemonic == "word":
            continue
        found = decode(code, int(address, 16))
        name = FOLLOWED.get(mnemonic, "branch" if mnemonic.startswith("br") else "other")
        assert (found.name, found.size) == (name, len(words.split())), (address, mnemonic)
        check_operands(found, mnemonic, operands, target)
        seen.add(found.name)
    assert seen >= SAME - {"adc", "eor", "sei"} | {"branch", "skip"}


def test_outside_the_code_nothing_is_decoded() -> None:
    for address in (-2, 1, 2):
        with pytest.raises(IndexError):
            decode(b"\x00\x00", address)
