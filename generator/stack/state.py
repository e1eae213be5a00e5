# SPDX-License-Identifier: GPL-3.0-or-later
"""The known contents of registers and stack pointer at one point of a function.

A register contains a constant, a byte of an address on the stack, or an unknown value. An address
on the stack is given by its depth: bytes below the stack pointer at the function's entry.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

from heatwright.generator.stack.instructions import Instruction

SPL, SPH = 0x3D, 0x3E

# Registers that a C function preserves (avr-gcc's calling convention).
KEPT_BY_CALLS = frozenset([*range(2, 18), 28, 29])


class StackUnknown(ValueError):
    """The stack of a program cannot be computed from its code; the text says why."""


class Byte(NamedTuple):
    """A register's content.

    `constant`: `number`. `low` and `high`: that byte of the stack's address at depth `number`.
    `low_less`: the low byte at depth `number`, minus `less`; the high byte will follow.
    """

    kind: Literal["constant", "low", "high", "low_less"]
    number: int
    less: int = 0


Registers = tuple[Byte | None, ...]
UNKNOWN: Registers = (None,) * 32

# A C function may rely on 0 in r1, and keeps it.
CALLED: Registers = (None, Byte("constant", 0), *UNKNOWN[2:])


@dataclass(frozen=True, slots=True)
class State:
    """Depth of the stack, and the content of each register (None: unknown).

    `half` was written to one half of the stack pointer; the other half has not been written yet.
    """

    depth: int
    registers: Registers = UNKNOWN
    half: Byte | None = None

    def holding(self, values: dict[int, Byte | None]) -> "State":
        """Return the state with some registers changed."""
        return replace(
            self, registers=tuple(values.get(n, old) for n, old in enumerate(self.registers))
        )

    def after_call(self) -> "State":
        """Return the state after the return of a called function."""
        return self.holding({n: CALLED[n] for n in range(32) if n not in KEPT_BY_CALLS})

    def joined(self, other: "State") -> "State":
        """Return the contents that two states of the same depth have in common."""
        both = tuple(
            a if a == b else None for a, b in zip(self.registers, other.registers, strict=True)
        )
        return replace(self, registers=both, half=self.half if self.half == other.half else None)

    def pointer(self, register: int) -> int | None:
        """Return the constant in the register pair from `register` on."""
        low, high = self.registers[register : register + 2]
        if low is None or high is None or {low.kind, high.kind} != {"constant"}:
            return None
        return low.number | high.number << 8


def advance(state: State, instruction: Instruction, stack_top: int) -> State:
    """Return the state after an instruction that only computes.

    `stack_top` is the address to which the program first sets its stack pointer.
    """
    effect = _EFFECTS.get(instruction.name)
    if effect is None:
        return state.holding(dict.fromkeys(instruction.writes))
    return effect(state, instruction, stack_top)


def _copy_pair(state: State, instruction: Instruction, _: int) -> State:
    d, r = instruction.d, instruction.r
    return state.holding({d: state.registers[r], d + 1: state.registers[r + 1]})


def _eor(state: State, instruction: Instruction, _: int) -> State:
    same = instruction.d == instruction.r
    return state.holding({instruction.d: Byte("constant", 0) if same else None})


def _in(state: State, instruction: Instruction, _: int) -> State:
    byte = None
    if state.half is None and instruction.k == SPL:
        byte = Byte("low", state.depth)
    elif state.half is None and instruction.k == SPH:
        byte = Byte("high", state.depth)
    return state.holding({instruction.d: byte})


def _move_pair(state: State, instruction: Instruction, less: int) -> State:
    d = instruction.d
    low, high = state.registers[d : d + 2]
    if low is None or high is None or low.kind != "low" or high != Byte("high", low.number):
        return state.holding({d: None, d + 1: None})
    depth = low.number + less
    return state.holding({d: Byte("low", depth), d + 1: Byte("high", depth)})


def _move_high(state: State, d: int, less: int) -> State:
    """Change a stack address in a pair by 256: the compiler then changes only the high register."""
    low, high = state.registers[d - 1 : d + 1] if d else (None, None)
    if high is None or high.kind != "high" or low != Byte("low", high.number):
        return state.holding({d: None})
    depth = high.number + less
    return state.holding({d - 1: Byte("low", depth), d: Byte("high", depth)})


def _less(state: State, d: int, less: int | None) -> State:
    """Subtract a constant from a register: the low half of a subtraction."""
    byte = state.registers[d]
    if byte is None or less is None or byte.kind != "low":
        return state.holding({d: None})
    return state.holding({d: Byte("low_less", byte.number, less)})


def _less_high(state: State, d: int, less: int | None) -> State:
    """Subtract a constant and the borrow from a register: the high half of a subtraction."""
    low, high = state.registers[d - 1], state.registers[d]
    if less is None or low is None or low.kind != "low_less" or high != Byte("high", low.number):
        return state.holding({d: None})
    taken = (low.less + (less << 8)) & 0xFFFF
    depth = low.number + (taken - 0x10000 if taken & 0x8000 else taken)
    return state.holding({d - 1: Byte("low", depth), d: Byte("high", depth)})


def _constant(state: State, register: int) -> int | None:
    byte = state.registers[register]
    return byte.number if byte is not None and byte.kind == "constant" else None


def _negated(number: int | None) -> int | None:
    return None if number is None else -number


def _out(state: State, instruction: Instruction, stack_top: int) -> State:
    if instruction.k not in (SPL, SPH):
        return state
    byte = state.registers[instruction.d]
    half: Literal["low", "high"] = "low" if instruction.k == SPL else "high"
    if byte is not None and byte.kind == "constant":
        expected = stack_top & 0xFF if half == "low" else stack_top >> 8
        byte = Byte(half, 0) if byte.number == expected else None
    if byte is None or byte.kind != half:
        raise StackUnknown(
            f"sets the stack pointer to an unknown value at 0x{instruction.address:x}"
        )
    if state.half is None:
        return replace(state, half=byte)
    if state.half.kind == half or state.half.number != byte.number:
        raise StackUnknown(f"the stack pointer is set by halves at 0x{instruction.address:x}")
    return replace(state, depth=byte.number, half=None)


_EFFECTS: dict[str, Callable[[State, Instruction, int], State]] = {
    "push": lambda state, _, __: replace(state, depth=state.depth + 1),
    "pop": lambda state, i, _: replace(state.holding({i.d: None}), depth=state.depth - 1),
    "ldi": lambda state, i, _: state.holding({i.d: Byte("constant", i.k)}),
    "mov": lambda state, i, _: state.holding({i.d: state.registers[i.r]}),
    "movw": _copy_pair,
    "eor": _eor,
    "in": _in,
    "out": _out,
    "adiw": lambda state, i, _: _move_pair(state, i, -i.k),
    "sbiw": lambda state, i, _: _move_pair(state, i, i.k),
    "dec": lambda state, i, _: _move_high(state, i.d, 0x100),
    "inc": lambda state, i, _: _move_high(state, i.d, -0x100),
    "subi": lambda state, i, _: _less(state, i.d, i.k),
    "sbci": lambda state, i, _: _less_high(state, i.d, i.k),
    "sub": lambda state, i, _: _less(state, i.d, _constant(state, i.r)),
    "sbc": lambda state, i, _: _less_high(state, i.d, _constant(state, i.r)),
    "add": lambda state, i, _: _less(state, i.d, _negated(_constant(state, i.r))),
    "adc": lambda state, i, _: _less_high(state, i.d, _negated(_constant(state, i.r))),
}
