# SPDX-License-Identifier: GPL-3.0-or-later
"""Decodes AVR machine code, as far as it changes the stack pointer or the program flow.

Encodings from the AVR Instruction Set Manual (Microchip DS40002198). An instruction
that changes neither stack nor program flow is `other`, with the registers that it changes.
"""

from collections.abc import Callable
from dataclasses import dataclass

X, Y, Z = 26, 28, 30


@dataclass(frozen=True, slots=True)
class Instruction:
    """One instruction at a byte address.

    `d` and `r` are registers, `k` is an immediate, an I/O address or, for a jump or call, the
    target's byte address; `writes` are the registers whose new contents are not followed.
    """

    address: int
    size: int
    name: str
    d: int = 0
    r: int = 0
    k: int = 0
    writes: tuple[int, ...] = ()

    @property
    def next(self) -> int:
        """Return the address of the instruction after it."""
        return self.address + self.size


def decode(code: bytes, address: int) -> Instruction:
    """Decode the instruction at `address`; IndexError outside the code."""
    word = _word(code, address)
    for mask, value, name, operands in _TABLE:
        if word & mask == value:
            return operands(code, address, word, name)
    return Instruction(address, 2, "other")


def _word(code: bytes, address: int) -> int:
    if not 0 <= address <= len(code) - 2:
        raise IndexError(address)
    return code[address] | code[address + 1] << 8


def _d5(word: int) -> int:
    return word >> 4 & 31


def _signed(value: int, bits: int) -> int:
    return value - (1 << bits) if value >> (bits - 1) else value


def _plain(_: bytes, address: int, __: int, name: str) -> Instruction:
    return Instruction(address, 2, name)


def _two(_: bytes, address: int, word: int, name: str) -> Instruction:
    return Instruction(address, 2, name, d=_d5(word), r=(word & 15) | (word >> 5 & 16))


def _two_changed(_: bytes, address: int, word: int, name: str) -> Instruction:
    return Instruction(address, 2, name, writes=(_d5(word),))


def _immediate(_: bytes, address: int, word: int, name: str) -> Instruction:
    return Instruction(
        address, 2, name, d=16 + (word >> 4 & 15), k=(word >> 4 & 0xF0) | (word & 15)
    )


def _immediate_changed(_: bytes, address: int, word: int, name: str) -> Instruction:
    return Instruction(address, 2, name, writes=(16 + (word >> 4 & 15),))


def _word_immediate(_: bytes, address: int, word: int, name: str) -> Instruction:
    return Instruction(address, 2, name, d=24 + (word >> 3 & 6), k=(word >> 2 & 0x30) | (word & 15))


def _pair(_: bytes, address: int, word: int, name: str) -> Instruction:
    return Instruction(address, 2, name, d=word >> 3 & 30, r=word << 1 & 30)


def _product(_: bytes, address: int, __: int, name: str) -> Instruction:
    return Instruction(address, 2, name, writes=(0, 1))


def _register(_: bytes, address: int, word: int, name: str) -> Instruction:
    return Instruction(address, 2, name, d=_d5(word))


def _io(_: bytes, address: int, word: int, name: str) -> Instruction:
    return Instruction(address, 2, name, d=_d5(word), k=(word >> 5 & 0x30) | (word & 15))


def _long(code: bytes, address: int, word: int, name: str) -> Instruction:
    high = (word >> 3 & 0x3E) | (word & 1)
    return Instruction(address, 4, name, k=(high << 16 | _word(code, address + 2)) * 2)


def _relative(_: bytes, address: int, word: int, name: str) -> Instruction:
    return Instruction(address, 2, name, k=address + 2 + 2 * _signed(word & 0xFFF, 12))


def _branch(_: bytes, address: int, word: int, name: str) -> Instruction:
    return Instruction(address, 2, name, k=address + 2 + 2 * _signed(word >> 3 & 127, 7))


def _direct(_: bytes, address: int, word: int, name: str) -> Instruction:
    load = word & 0x0200 == 0
    return Instruction(address, 4, name, writes=(_d5(word),) if load else ())


# By the low four bits of `ld` and `st`: the pointer that a load or store moves.
_MOVED = {1: Z, 2: Z, 5: Z, 7: Z, 9: Y, 10: Y, 13: X, 14: X}


def _pointer(_: bytes, address: int, word: int, name: str) -> Instruction:
    moved = _MOVED.get(word & 15)
    exchange = word & 0x0200 and word & 15 in (4, 5, 6, 7)
    load = word & 0x0200 == 0 or exchange
    changed: tuple[int, ...] = (_d5(word),) if load else ()
    if moved is not None and not exchange:
        changed += (moved, moved + 1)
    return Instruction(address, 2, name, writes=changed)


Operands = Callable[[bytes, int, int, str], Instruction]

# Mask, value, name, operands. The first match is used.
_TABLE: tuple[tuple[int, int, str, Operands], ...] = (
    (0xFF00, 0x0100, "movw", _pair),
    (0xFE00, 0x0200, "other", _product),  # muls, mulsu, fmul...
    (0xFC00, 0x0400, "other", _plain),  # cpc
    (0xFC00, 0x0800, "sbc", _two),
    (0xFC00, 0x0C00, "add", _two),
    (0xFC00, 0x1000, "skip", _plain),  # cpse
    (0xFC00, 0x1400, "other", _plain),  # cp
    (0xFC00, 0x1800, "sub", _two),
    (0xFC00, 0x1C00, "adc", _two),
    (0xFC00, 0x2400, "eor", _two),
    (0xFC00, 0x2C00, "mov", _two),
    (0xF000, 0x2000, "other", _two_changed),  # and, or
    (0xF000, 0x3000, "other", _plain),  # cpi
    (0xF000, 0x4000, "sbci", _immediate),
    (0xF000, 0x5000, "subi", _immediate),
    (0xE000, 0x6000, "other", _immediate_changed),  # ori, andi
    (0xD200, 0x8000, "other", _two_changed),  # ldd
    (0xD200, 0x8200, "other", _plain),  # std
    (0xFC0F, 0x9000, "other", _direct),  # lds, sts
    (0xFE0F, 0x900F, "pop", _register),
    (0xFE0F, 0x920F, "push", _register),
    (0xFC00, 0x9000, "other", _pointer),  # ld, st, lpm, elpm
    (0xFFFF, 0x9409, "ijmp", _plain),
    (0xFFFF, 0x9419, "ijmp", _plain),  # eijmp
    (0xFFFF, 0x9509, "icall", _plain),
    (0xFFFF, 0x9519, "icall", _plain),  # eicall
    (0xFFFF, 0x9478, "sei", _plain),
    (0xFFFF, 0x9508, "ret", _plain),
    (0xFFFF, 0x9518, "ret", _plain),  # reti
    (0xFFEF, 0x95C8, "other", _product),  # lpm, elpm to r0
    (0xFE0E, 0x940C, "jmp", _long),
    (0xFE0E, 0x940E, "call", _long),
    (0xFE0F, 0x9408, "other", _plain),  # flags, sleep, wdr, spm...
    (0xFE0F, 0x9403, "inc", _register),
    (0xFE0F, 0x940A, "dec", _register),
    (0xFE00, 0x9400, "other", _two_changed),  # com, neg, swap, asr, lsr, ror
    (0xFF00, 0x9600, "adiw", _word_immediate),
    (0xFF00, 0x9700, "sbiw", _word_immediate),
    (0xFD00, 0x9800, "other", _plain),  # cbi, sbi
    (0xFD00, 0x9900, "skip", _plain),  # sbic, sbis
    (0xFC00, 0x9C00, "other", _product),  # mul
    (0xF800, 0xB000, "in", _io),
    (0xF800, 0xB800, "out", _io),
    (0xF000, 0xC000, "jmp", _relative),
    (0xF000, 0xD000, "call", _relative),
    (0xF000, 0xE000, "ldi", _immediate),
    (0xF800, 0xF000, "branch", _branch),
    (0xFE08, 0xF800, "other", _two_changed),  # bld
    (0xFC08, 0xFC00, "skip", _plain),  # sbrc, sbrs
)
