# SPDX-License-Identifier: GPL-3.0-or-later
"""Follow every path of a function, and find its greatest stack depth.

An instruction that is reached with two depths, a call to an address in a register, and a function
that calls itself are refused: the code alone does not give their depth.
"""

from bisect import bisect_right
from dataclasses import dataclass, field, replace

from heatwright.generator.stack.instructions import Instruction, Z, decode
from heatwright.generator.stack.state import (
    CALLED,
    UNKNOWN,
    Registers,
    StackUnknown,
    State,
    advance,
)

# libgcc's routine for a `switch`: a jump within the function, by a table in flash.
TABLE_JUMPS = ("__tablejump2__", "__tablejump__")


@dataclass(frozen=True)
class Program:
    """The code of a binary: its bytes from address 0, its functions, and properties of its chip.

    `functions` are (address, end, name), in order. `call_bytes` is the size of a return address on
    the stack. `stack_top` is the stack pointer at the start.
    """

    code: bytes
    functions: tuple[tuple[int, int, str], ...]
    call_bytes: int
    stack_top: int

    def function_at(self, address: int) -> tuple[int, int, str]:
        """Return start, end and name of the function that contains an address."""
        index = bisect_right(self.functions, (address, 1 << 32, "")) - 1
        if index >= 0 and address < self.functions[index][1]:
            return self.functions[index]
        return (address, address, f"0x{address:x}" if address else "reset")


@dataclass(frozen=True)
class Depth:
    """The greatest stack depth of a function in bytes, without its own return address.

    `chain` names the functions of the deepest chain of calls, from this one on.
    """

    bytes: int
    chain: tuple[str, ...]
    returns: bool
    enables_interrupts: bool


@dataclass
class Analysis:
    """The depths of a program's functions, each computed once."""

    program: Program
    known: dict[int, Depth] = field(default_factory=dict)
    open: list[int] = field(default_factory=list)

    def interrupt(self, entry: int) -> Depth:
        """Return the depth of the interrupt handler that begins at an address."""
        return _Walk(self, entry).run(UNKNOWN)

    def function(self, entry: int) -> Depth:
        """Return the depth of the function that begins at an address."""
        if entry in self.known:
            return self.known[entry]
        if entry in self.open:
            names = [self.program.function_at(at)[2] for at in [*self.open, entry]]
            raise StackUnknown(f"{names[-1]} calls itself: {' → '.join(names)}")
        self.open.append(entry)
        found = _Walk(self, entry).run(CALLED)
        self.open.pop()
        self.known[entry] = found
        return found


class _Walk:
    """Follows every path of one function."""

    def __init__(self, analysis: Analysis, entry: int) -> None:
        self.analysis = analysis
        self.program = analysis.program
        self.entry = entry
        self.name = self.program.function_at(entry)[2]
        self.states: dict[int, State] = {}
        self.work: list[int] = []
        self.switches: list[tuple[int, int, State]] = []
        self.tables: dict[int, int] = {}
        self.deepest = 0
        self.chain: tuple[str, ...] = (self.name,)
        self.returns = False
        self.enables = False

    def run(self, registers: Registers) -> Depth:
        self.reach(self.entry, State(0, registers))
        while self.work or self.open_switch():
            self.step(self.work.pop())
        return Depth(self.deepest, self.chain, self.returns, self.enables)

    def reach(self, address: int, state: State) -> None:
        """Record that the flow reaches `address` in `state`."""
        before = self.states.get(address)
        if before is None:
            self.states[address] = state
            self.work.append(address)
            return
        if before.depth != state.depth:
            raise StackUnknown(
                f"{self.name} comes to 0x{address:x} with {before.depth} and with {state.depth}"
                " bytes on the stack"
            )
        joined = before.joined(state)
        if joined != before:
            self.states[address] = joined
            self.work.append(address)

    def open_switch(self) -> bool:
        """Let a jump through a table reach the first instruction not reached in another way.

        A table that is not directly behind its jump is not read. A case that is not reached
        otherwise begins after a jump or return; the compiler keeps one depth for each place, so the
        state of the table jump holds there.
        """
        for start, end, state in self.switches:
            address = start
            while address < end:
                if address in self.tables:
                    address = self.tables[address]
                    continue
                if address not in self.states:
                    self.reach(address, state)
                    return True
                address = decode(self.program.code, address).next
        return False

    def read_table(self, jump: Instruction, state: State) -> None:
        """Follow the table of a switch directly behind its jump, where gcc 7 puts it.

        Its words are addresses within the function. The table ends where the first case after it
        begins: only a case or another jump's target can be there.
        """
        table = jump.next
        if self.table_address(jump) != table & 0x1FFFF:
            return
        start, end, _ = self.program.function_at(jump.address)
        at, limit = table, end
        while at < limit:
            target = 2 * int.from_bytes(self.program.code[at : at + 2], "little")
            if not start <= target < end:
                break
            self.reach(target, state)
            at += 2
            if target > table:
                limit = min(limit, target)
        self.tables[table] = at

    def table_address(self, jump: Instruction) -> int | None:
        """Return the address that the instructions before a jump add to the number of the case."""
        for address in range(jump.address - 4, jump.address - 12, -2):
            low, high = (decode(self.program.code, each) for each in (address, address + 2))
            if (low.name, low.d, high.name, high.d) == ("subi", Z, "sbci", Z + 1):
                return 2 * (-(low.k | high.k << 8) & 0xFFFF)
        return None

    def step(self, address: int) -> None:
        """Process one instruction."""
        state = self.states[address]
        try:
            instruction = decode(self.program.code, address)
        except IndexError:
            raise StackUnknown(f"{self.name} runs out of the code at 0x{address:x}") from None
        flow = getattr(self, f"on_{instruction.name}", None)
        if flow is not None:
            flow(instruction, state)
            return
        try:
            after = advance(state, instruction, self.program.stack_top)
        except StackUnknown as reason:
            raise StackUnknown(f"{self.name} {reason}") from None
        self.deepen(after.depth)
        self.reach(instruction.next, after)

    def deepen(self, depth: int, chain: tuple[str, ...] = ()) -> None:
        if depth > self.deepest:
            self.deepest = depth
            self.chain = (self.name, *chain)

    def on_branch(self, instruction: Instruction, state: State) -> None:
        self.reach(instruction.k, state)
        self.reach(instruction.next, state)

    def on_skip(self, instruction: Instruction, state: State) -> None:
        self.reach(instruction.next, state)
        self.reach(decode(self.program.code, instruction.next).next, state)

    def on_jmp(self, instruction: Instruction, state: State) -> None:
        if instruction.k == 0 and self.entry != 0:
            return  # a restart, with a stack of its own
        if self.program.function_at(instruction.k)[2] in TABLE_JUMPS:
            start, end, _ = self.program.function_at(instruction.address)
            # The routine works in r0, r24 and Z.
            after = state.holding(dict.fromkeys((0, 24, Z, Z + 1)))
            self.switches.append((start, end, after))
            self.read_table(instruction, after)
        self.reach(instruction.k, state)

    def on_ijmp(self, instruction: Instruction, state: State) -> None:
        if self.program.function_at(instruction.address)[2] in TABLE_JUMPS:
            if state.depth != self.switches[-1][2].depth:
                raise StackUnknown(f"{self.name} has a switch that moves the stack")
            return
        target = state.pointer(Z)
        if target is None:
            raise StackUnknown(
                f"{self.name} jumps to an address in a register at 0x{instruction.address:x}"
            )
        self.reach(target * 2, state)

    def on_icall(self, instruction: Instruction, _: State) -> None:
        raise StackUnknown(f"{self.name} calls a function by pointer at 0x{instruction.address:x}")

    def on_call(self, instruction: Instruction, state: State) -> None:
        below = state.depth + self.program.call_bytes
        if instruction.k == instruction.next:  # `rcall .+0` makes room on the stack
            self.deepen(below)
            self.reach(instruction.next, replace(state, depth=below))
            return
        callee = self.analysis.function(instruction.k)
        self.deepen(below + callee.bytes, callee.chain)
        self.enables |= callee.enables_interrupts
        if callee.returns:
            self.reach(instruction.next, state.after_call())

    def on_ret(self, instruction: Instruction, state: State) -> None:
        if state.depth != 0:
            raise StackUnknown(
                f"{self.name} returns at 0x{instruction.address:x} with {state.depth} bytes"
                " on the stack"
            )
        self.returns = True

    def on_sei(self, instruction: Instruction, state: State) -> None:
        self.enables = True
        self.reach(instruction.next, state)
