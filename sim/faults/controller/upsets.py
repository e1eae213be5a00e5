"""Single-event upsets: a random bit flips, or the processor jumps; judge what follows.

A bit of the static RAM, the stack, a working register, a peripheral register, the flash or the
EEPROM is inverted, or the program counter is set to anywhere in the program. This happens at a
random moment in a loop that heats, that is off, or that has a latched fault without its cause. A
peripheral register acts as if an instruction had written it. A flip in the EEPROM is followed by a
loss of power, because the EEPROM is read only at start-up.
"""

from collections.abc import Callable, Mapping
from random import Random
from typing import NamedTuple

from heatwright.sim.avr import AvrError
from heatwright.sim.binary.elf import Elf
from heatwright.sim.faults import starts
from heatwright.sim.faults.bounds import TICK_S
from heatwright.sim.faults.controller import memory
from heatwright.sim.faults.site import Site
from heatwright.sim.faults.world import STEP_S, World
from heatwright.spec import Controller
from heatwright.spec.facts import facts_of

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
"""How long the last decision before the upset may keep the heater on, in periods."""

HEATS, TOO_HOT, FORGETS = "heats", "too hot", "forgets"
"""Bad outcomes: a heater on beyond its bound, a node hotter than its limit, a fault that is no
longer latched although nobody acknowledged it."""
BAD = (HEATS, TOO_HOT, FORGETS)
RESULTS = ("nothing", "told", "reset", "unknown", *BAD)
"""All outcomes; told -- a fault was latched; unknown -- it did something that is not simulated."""


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
    "hot": starts.heating,
    "latched": memory.latched,
    "off": off,
}


def draw(controller: Controller, program: Elf, number: int, seed: int) -> Upset:
    """Draw an upset by its number: the same for the same seed and program."""
    random = Random(f"upset {seed} {number}")  # noqa: S311 - no secret
    site = Site(controller, random.choice(list(controller.loops)), program)
    states = [each for each in STATES if each != "off" or site.facts.commanded]
    kind = random.choice(KINDS)
    return Upset(
        number,
        site.loop_name,
        random.choice(states),
        random.uniform(0.0, site.loop.periods_s(PERIODS)),
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
    world = STATES[upset.state](site)
    world.run(upset.after_s)
    world.device.avr.take_resets()
    world.watch_peaks()
    since_s, before, acknowledged = world.now_s, world.fault, _acknowledgements(world)
    try:
        _strike(world, upset)
        world.run(max(WATCH_S, site.loop.periods_s(WATCH_PERIODS)))
        result, words = _judged(world, upset, since_s, acknowledged)
    except AvrError as error:
        return Outcome(upset, "unknown", str(error))
    if result == "nothing" and world.fault != before:
        result = "told"
    return Outcome(upset, result, words)


def _strike(world: World, upset: Upset) -> None:
    avr = world.device.avr
    if upset.kind == "eeprom":
        image = bytearray(avr.eeprom.contents)
        image[upset.address] ^= 1 << upset.bit
        avr.eeprom.contents = bytes(image)
        world.power_cut(STEP_S)
    elif upset.kind == "flash":
        avr.flip_flash(upset.address, upset.bit)
    elif upset.kind == "jump":
        avr.jump(upset.address)
    else:
        avr.flip(upset.address, upset.bit)


def _acknowledgements(world: World) -> int:
    return int(world.device.read("fault.acknowledgements"))


def _judged(
    world: World, upset: Upset, since_s: float, acknowledged_before: int
) -> tuple[str, str]:
    """Return one of RESULTS, judged by machine and pins, and an explanation if it is bad."""
    resets = upset.kind != "eeprom" and len(world.device.avr.take_resets())
    acknowledged = not resets and _acknowledgements(world) != acknowledged_before
    starts_anew = resets and facts_of(world.site.controller, upset.loop).starts_enabled
    must_be_off = (upset.state == "latched" and not acknowledged) or (
        upset.state == "off" and not starts_anew
    )
    heater = world.heaters if upset.state == "latched" else world.heater
    last_s = heater.last_on_s(since_s + world.site.loop.periods_s(PERIODS) + 2 * TICK_S)
    if must_be_off and last_s is not None:
        return HEATS, f"a heater was on {last_s - since_s:.2f} s after the upset"
    if upset.state == "latched" and not world.fault and not acknowledged:
        return FORGETS, "the latched fault was lost without an acknowledgement"
    bears_c = world.bears_c
    for node, peak_c in world.peaks.highest_c.items():
        if peak_c > bears_c[node]:
            return TOO_HOT, f"{node} reached {peak_c:.1f} °C, its limit is {bears_c[node]:.1f} °C"
    return "reset" if resets else "nothing", ""
