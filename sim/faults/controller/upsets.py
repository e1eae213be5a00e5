"""Single-event upsets: a random bit flips, or the processor jumps; judge what follows.

A bit of the static RAM, the stack, a working register, a peripheral register, the flash or the
EEPROM is inverted, or the program counter is set to anywhere in the program. This happens at a
random cycle in a loop that is hot, that heats up from cold, whose program runs, that is off, or
that has a latched fault without its cause. A peripheral register acts as if an instruction had
written it. A flip in the EEPROM is followed by a loss of power, because the EEPROM is read only at
start-up.

Where heaters may be on, the same world without the upset shows how much heat is right: nothing else
differs. A difference is harmless if it is at most full power for as long as a heater that must be
off may be on, because the last decision before the upset may have been to heat. A machine whose
heaters give more is followed until they no longer do, and until its heat has spread; that must
happen within the time of the slowest rule, or of two checks of the flash. A heater that stays at
full power is detected in the state hot, in which the healthy heater goes off soon.
"""

from collections.abc import Callable, Mapping
from functools import lru_cache
from random import Random
from typing import NamedTuple

import numpy as np

from heatwright.sim.avr import AvrError
from heatwright.sim.binary.elf import Elf
from heatwright.sim.faults import starts
from heatwright.sim.faults.bounds import TICK_S, flash_s
from heatwright.sim.faults.controller import memory
from heatwright.sim.faults.machine import asked_share, longest_rule_s
from heatwright.sim.faults.operation.programs import first_segments, in_segment
from heatwright.sim.faults.peaks import SPREADING_S
from heatwright.sim.faults.site import Site
from heatwright.sim.faults.world import SPREAD, STEP_S, World
from heatwright.spec import Controller, Loop, facts_of

KINDS = ("ram", "stack", "register", "periphery", "flash", "eeprom", "jump")
GUARDED = ("ram", "stack", "register", "periphery", "eeprom")
"""No upset of these kinds may have a bad outcome; flipped bits in the flash, and jumps, are a risk
that docs/safety.md lists."""
STACK_BYTES = 64
"""Size of the area at the top of the RAM: more than the stack of the sleeping program."""
PERIPHERY_START = 0x20
"""Addresses below this are the working registers."""
RECORDS_BYTES = 256
"""Size of the area at the start of the EEPROM with the settings and the latched fault."""
WATCH_S = 30.0
WATCH_PERIODS = 10
PERIODS = 2
"""How long the last decision before the upset may keep a heater on, in periods."""

HEATS, TOO_HOT, FORGETS = "heats", "too hot", "forgets"
"""Bad outcomes: a heater on beyond its bound, a node hotter than its limit, a fault that is no
longer latched although nobody acknowledged it."""
BAD = (HEATS, TOO_HOT, FORGETS)
RESULTS = ("nothing", "told", "reset", "unknown", *BAD)
"""All outcomes; told -- a fault was latched; unknown -- something that is not simulated."""


class Upset(NamedTuple):
    """One upset: loop, its state, time in that state (s), kind of memory, address and bit.

    address -- in the data space, the EEPROM or the flash, in bytes.
    """

    number: int
    loop: str
    state: str
    after_s: float
    kind: str
    address: int
    bit: int

    def __str__(self) -> str:
        """Describe the upset in one line."""
        place = f"{self.kind} 0x{self.address:04X}"
        where = place if self.kind == "jump" else f"{place} bit {self.bit}"
        return f"upset {self.number}: {where}, {self.loop} {self.state}, after {self.after_s:.3f} s"


class Outcome(NamedTuple):
    """The outcome of an upset: one of RESULTS, with an explanation if it is bad or unknown."""

    upset: Upset
    result: str
    words: str


def off(site: Site) -> World:
    """Return a warm world whose loop its operator has just switched off."""
    world = starts.heating(site)
    if site.facts.switched:
        world.switch(on=False)
    else:
        world.set_setpoint(0.0)
    world.run(site.loop.periods_s(PERIODS) + STEP_S)
    return world


STATES: Mapping[str, Callable[[Site], World]] = {
    "hot": starts.held,
    "cold": starts.warming_up,
    "latched": memory.latched,
    "off": off,
}
PROGRAMMED = "programmed"
"""The state in which a program runs; the number of its segment follows."""


def draw_state(site: Site, random: Random) -> str:
    """Draw one of the states that a loop can have."""
    segments = first_segments(site)
    states = [each for each in STATES if each != "off" or site.facts.commanded]
    state = random.choice([*states, *([PROGRAMMED] if segments else [])])
    return f"{state} {random.randint(1, len(segments))}" if state == PROGRAMMED else state


def begun(site: Site, state: str) -> World:
    """Return a world in one of the states."""
    name, _, segment = state.partition(" ")
    return in_segment(site, int(segment)) if segment else STATES[name](site)


def draw(controller: Controller, program: Elf, number: int, seed: int) -> Upset:
    """Draw an upset by its number: the same for the same seed and program."""
    random = Random(f"upset {seed} {number}")  # noqa: S311 - no secret
    site = Site(controller, random.choice(list(controller.loops)), program)
    state, kind = draw_state(site, random), random.choice(KINDS)
    most_s = span_s(site) if state.startswith(PROGRAMMED) else site.loop.periods_s(PERIODS)
    return Upset(
        number,
        site.loop_name,
        state,
        random.uniform(0.0, most_s),
        kind,
        _address(controller, program, kind, random),
        random.randrange(8),
    )


def _address(controller: Controller, program: Elf, kind: str, random: Random) -> int:
    board = controller.board
    ram_end = board.ram_start + board.ram_bytes
    places = {
        "ram": range(*program.static_ram),
        "stack": range(ram_end - STACK_BYTES, ram_end),
        "register": range(PERIPHERY_START),
        "periphery": range(PERIPHERY_START, board.ram_start),
        "flash": range(len(program.flash)),
        "eeprom": range(min(RECORDS_BYTES, board.eeprom_bytes)),
        "jump": range(0, len(program.flash), 2),
    }
    return random.choice(places[kind])


def try_upset(controller: Controller, program: Elf, upset: Upset) -> Outcome:
    """Try an upset in its own world."""
    site = Site(controller, upset.loop, program)
    world = begun(site, upset.state)
    whole = int(upset.after_s / world.step_s)
    world.run(whole * world.step_s)
    world.device.avr.take_resets()
    world.watch_peaks()
    before, acknowledged, first = world.fault, _acknowledgements(world), world.steps
    try:
        since_s = _strike(world, upset, upset.after_s - whole * world.step_s)
        world.run(span_s(site))
        result, words = _judged(world, upset, since_s, acknowledged, first)
    except AvrError as error:
        return Outcome(upset, "unknown", str(error))
    if result == "nothing" and world.fault != before:
        result = "told"
    return Outcome(upset, result, words)


def _strike(world: World, upset: Upset, after_s: float) -> float:
    """Cause the upset `after_s` after this step has begun; return its device time, s."""
    avr, since_s = world.device.avr, world.now_s + after_s
    if upset.kind == "eeprom":
        image = bytearray(avr.eeprom.contents)
        image[upset.address] ^= 1 << upset.bit
        avr.eeprom.contents = bytes(image)
        world.power_cut(STEP_S)
        return since_s

    def act(until_s: float) -> None:
        world.device.advance(since_s)
        if upset.kind == "flash":
            avr.flip_flash(upset.address, upset.bit)
        elif upset.kind == "jump":
            avr.jump(upset.address)
        else:
            avr.flip(upset.address, upset.bit)
        world.device.advance(until_s)

    world.act_within(act)
    return since_s


def span_s(site: Site) -> float:
    """Return the shortest time for which a world is watched, s."""
    return max(WATCH_S, site.loop.periods_s(WATCH_PERIODS))


def _bound_s(loop: Loop) -> float:
    """Return how long the last decision before the upset may keep a heater on, s."""
    return loop.periods_s(PERIODS) + 2 * TICK_S


@lru_cache(maxsize=16)
def _healthy(site: Site, state: str, cut_s: float | None) -> World:
    """Return the world without the upset; cut_s -- time from its beginning to its power cut, s."""
    world = begun(site, state)
    if cut_s is not None:
        world.run(cut_s)
        world.power_cut(STEP_S)
    return world


def _still_heats(world: World, upset: Upset, first: int) -> str:
    """Follow a world that gets more heat than without the upset; return "" if this ends in time.

    It has ended if the heat is the same for so long that the loop's heater, at full power, would
    have exceeded the bound twice. A machine in the state hot is watched for at least that time.
    """
    site, loops, step_s = world.site, world.site.controller.loops, world.step_s
    bounds_s = np.array([_bound_s(loop) for loop in loops.values()])
    if np.all(world.heat_s(first, world.steps) <= bounds_s):
        return ""
    own, full = list(loops).index(site.loop_name), site.loop.algorithm.full_percent
    share, follow_s = asked_share(site, full), max(flash_s(site.program), longest_rule_s(site))
    cut_s = int(upset.after_s / step_s) * step_s if upset.kind == "eeprom" else None
    healthy, begun_s = _healthy(site, upset.state, cut_s), world.now_s
    same, before_s = first, np.zeros(len(loops))
    while True:
        last = world.steps
        healthy.run(max(0, last - healthy.steps) * step_s)
        more_s = world.heat_s(first, last) - healthy.heat_s(first, last)
        left_out_s = share * (last - same) * step_s - healthy.heat_s(same, last)[own]
        if np.any(more_s - before_s > bounds_s):
            if world.now_s > begun_s + follow_s:
                return f"a heater was on for {max(more_s):.1f} s more than without the upset"
            same, before_s = last, more_s
        elif (
            left_out_s > 2 * bounds_s[own]
            or (same == first and upset.state != "hot")
            or world.now_s > begun_s + 2 * follow_s
        ):
            world.until(SPREAD, SPREADING_S)
            return ""
        world.run(span_s(site))


def _acknowledgements(world: World) -> int:
    return int(world.device.read("fault.acknowledgements"))


def _judged(
    world: World, upset: Upset, since_s: float, acknowledged_before: int, first: int
) -> tuple[str, str]:
    """Return one of RESULTS, judged by machine and pins, and an explanation if it is bad."""
    resets = upset.kind != "eeprom" and len(world.device.avr.take_resets())
    acknowledged = not resets and _acknowledgements(world) != acknowledged_before
    starts_anew = resets and facts_of(world.site.controller, upset.loop).starts_enabled
    must_be_off = (upset.state == "latched" and not acknowledged) or (
        upset.state == "off" and not starts_anew
    )
    heater = world.heaters if upset.state == "latched" else world.heater
    last_s = heater.last_on_s(since_s + _bound_s(world.site.loop))
    if must_be_off and last_s is not None:
        return HEATS, f"a heater was on {last_s - since_s:.2f} s after the upset"
    if upset.state == "latched" and not world.fault and not acknowledged:
        return FORGETS, "the latched fault was lost without an acknowledgement"
    follows = must_be_off or upset.state not in {"latched", "off"}
    if follows and (words := _still_heats(world, upset, first)):
        return HEATS, words
    bears_c = world.bears_c
    for node, peak_c in world.peaks.highest_c.items():
        if peak_c > bears_c[node]:
            return TOO_HOT, f"{node} reached {peak_c:.1f} °C, its limit is {bears_c[node]:.1f} °C"
    return "reset" if resets else "nothing", ""
