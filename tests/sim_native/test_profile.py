"""The profile of our core, which tells it of changes only, and of simavr's, which is stepped: the
same numbers for the same code."""

from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from rig.firmware import compiled, controller_of, powered, shared, whole
from suite import amount
from test_core import MASKED, loaded, ran
from test_programs import PROFILED

from heatwright.sim.avr import Avr, instructions_by
from heatwright.sim.binary.elf import Elf, Function
from heatwright.sim.binary.profile import Profile
from heatwright.sim.device import AvrDevice
from heatwright.sim.timing.stage import Stage

STEPS_S = 0.5


def traced(avr: Avr, program: Elf) -> Profile:
    profile = avr.profile(program)
    for function in program.functions[:200]:
        profile.trace(function.name)
    return profile


def told(profile: Profile) -> dict[str, Any]:
    return {
        "functions": profile.functions, "entries": profile.log.take().tolist(),
        "masked": profile.masked, "busy": profile.busy, "stack": profile.stack_used,
        "reached": np.flatnonzero(profile.reached).tolist(),
    }  # fmt: skip


# A wait within a window, and around it jumps back, in and out; a function that goes on in another.
WINDOWS = """
volatile uint8_t n;
__attribute__((naked, noinline, used)) void falls(void) { asm volatile("inc r24"); }
__attribute__((naked, noinline, used)) void follows(void) { asm volatile("dec r24\\n ret"); }
__attribute__((noinline)) void frames(void) { volatile uint8_t kept[90]; kept[n & 63] = n; }
int main(void) {
    asm volatile("cli\\n out %0, r1\\n sei" :: "I"(_SFR_IO_ADDR(GPIOR0)));
    for (;;) {
        for (uint8_t i = 0; i < (n & 15); i++)
            asm volatile("rjmp 1f\\n nop\\n 1: rcall .+0\\n pop r0\\n pop r0" ::: "r0");
        falls(); frames();
        while (n++ & 7)
            if (n & 2)
                asm volatile(".rept 8\\n nop\\n .endr");
    }
}
"""
PROGRAMS = {
    "interrupts and sleep": lambda: shared("blink.c"), "masks": lambda: compiled(MASKED),
    "computations": lambda: shared("computed.c", "-lm"), "stretches": lambda: compiled(PROFILED),
    "windows": lambda: compiled(WINDOWS),
}  # fmt: skip


@pytest.mark.parametrize("what", PROGRAMS)
def test_programs_are_profiled_alike(what: str) -> None:
    program = PROGRAMS[what]()
    ours, theirs = (powered(program) for _ in range(2))
    theirs.use_simavrs_core()
    profiles = [traced(avr, program) for avr in (ours, theirs)]
    rng = np.random.default_rng(1)
    while ours.cycle < 400_000:
        cycle = ours.cycle + int(rng.integers(1, 20_000))
        for avr in (ours, theirs):
            avr.run_to(cycle)
        first, second = map(told, profiles)
        assert first == second


@pytest.mark.parametrize("name", ["chamber", "extruder", "fabricator"])
def test_firmware_is_profiled_alike(name: str) -> None:
    controller, program = controller_of(name), whole(name)
    found = []
    for core in ("own", "simavr"):
        with instructions_by(core):
            device = AvrDevice(controller, program)
        profile = traced(device.avr, program)
        Stage(controller, device, STEPS_S).advance(STEPS_S)
        found.append(told(profile))
    assert found[0] == found[1]


# Random code of little but what a profile looks at, with interrupts every few instructions. All
# it computes with are bytes below 16: of addresses in it, and mostly of some in the memory.
FLASH_WORDS = 0x1000
SMALL = 0x0F
SET_UP = [0xE002, 0x9300, 0x6E, 0xBD04, 0xE601, 0xBD07, 0xE001, 0xBD05, 0xC100]
"""TIMSK0 = TCCR0A = 2; OCR0A = 97; TCCR0B = 1; rjmp .+512"""
KINDS = {
    (0x2000, 0x0FFF): 8, (0xE000, 0x00FF): 2, (0x0000, 0x0000): 1,  # and to mov; ldi; nop
    (0xC000, 0x000F): 2, (0xCFF0, 0x000F): 1,  # rjmp on, back
    (0xF000, 0x047F): 4, (0xF380, 0x047F): 4,  # branches on, back
    (0x1000, 0x03FF): 1, (0xFC00, 0x03F7): 2,  # cpse, sbrc, sbrs
    (0xD000, 0x000F): 2, (0xDFF0, 0x000F): 1, (0xD000, 0x0000): 1,  # rcall on, back, .+0
    (0x940E, 0x0000): 1, (0x940C, 0x0000): 1, (0x9409, 0x0000): 0.1, (0x9509, 0x0000): 0.1,
    (0x9508, 0x0000): 3, (0x9518, 0x0000): 1,  # call, jmp, ijmp, icall; ret, reti
    (0x920F, 0x01F0): 2, (0x900F, 0x01F0): 2, (0x9200, 0x01F0): 1,  # push, pop, sts
    (0x94F8, 0x0000): 0.5, (0x9478, 0x0000): 2, (0xBE0F, 0x01F0): 0.2,  # cli, sei, out SREG
    (0xBE0D, 0x01F0): 0.2, (0xBE0E, 0x01F0): 0.02, (0x9588, 0x0000): 0.2,  # out SPL, SPH; sleep
}  # fmt: skip
LONG = {0x940E: (0, FLASH_WORDS), 0x940C: (0, FLASH_WORDS), 0x9200: (0x5D, 0x5F)}
"""Where the second word of an instruction lies: the stack pointer, of STS."""


def random_words(rng: np.random.Generator) -> list[int]:
    kinds = np.array(list(KINDS))
    weights = np.array(list(KINDS.values())) / sum(KINDS.values())
    chosen = kinds[rng.choice(len(kinds), FLASH_WORDS, p=weights)]
    drawn = rng.integers(0, 1 << 16, FLASH_WORDS)
    words: list[int] = (chosen[:, 0] | drawn & chosen[:, 1]).tolist()
    for place, kind in enumerate(chosen[:-1, 0].tolist()):
        if kind in LONG:
            words[place + 1] = int(rng.integers(*LONG[kind]))
    words[0x100 : 0x100 + len(SET_UP)] = SET_UP
    words[:2] = 0x940C, 0x100
    returns = int(rng.integers(0x200, FLASH_WORDS))
    words[0x1C:0x1E] = 0x940C, returns  # the timer's interrupt
    words[returns] = 0x9518
    return words


def processors(rng: np.random.Generator) -> tuple[list[Avr], Any]:
    words = np.array(random_words(rng), "<u2").tobytes()
    bounds = (np.unique(rng.integers(0, FLASH_WORDS, FLASH_WORDS // 20)) * 2).tolist()
    pairs = [pair for pair in pairwise(bounds) if rng.random() < 0.9]  # some code is of none
    functions = [Function(*pair, f"at_{pair[0]}") for pair in pairs]
    starts, names = ({getattr(each, key): each for each in functions} for key in ("start", "name"))
    known = {"functions": functions, "function_at": starts.get, "function": names.__getitem__}
    program = SimpleNamespace(**known)
    both = [loaded("atmega328p", words, simavrs=each) for each in (False, True)]
    memory = rng.integers(0, SMALL + 1, 0x900, np.uint8).tobytes()
    for avr in both:
        avr.write_ram(0, memory[:0x20])
        avr.write_ram(0x100, memory[0x100:])
    return both, program


@pytest.mark.parametrize("seed", range(4))
def test_random_code_is_profiled_alike(seed: int) -> None:
    rng = np.random.default_rng(seed)
    compared = 0
    for _ in range(amount("profiled_at_random")):
        both, program = processors(rng)
        profiles = [traced(avr, program) for avr in both]
        for _ in range(60):
            stack = int(rng.integers(0x200, 0x8F0)).to_bytes(2, "little")
            for avr in both:
                avr.write_ram(0x5D, stack)
            cycles = int(rng.integers(1, 300))
            if ran(both[0], cycles):
                break  # outside the memory, where simavr reads and writes ours
            assert not ran(both[1], cycles)
            assert both[0].cycle == both[1].cycle
            first, second = map(told, profiles)
            assert first == second
            if rng.random() < 0.4:
                for profile in profiles:
                    profile.stop()
                profiles = [traced(avr, program) for avr in both]
        compared += both[0].cycle
    assert compared > 1_000
