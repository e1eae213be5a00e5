"""Faults of the processor: a hung main loop, resets, a failing supply.

The program is made to hang without changing its code. While it sleeps in the wait for a tick, the
return address of that wait is on the stack. It is overwritten, as a disturbance of the RAM could
do, with the address of an empty endless loop that avr-libc puts into every program. Its entry
`__stop_program` leaves interrupts on; its entry `_exit` first switches them off.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from heatwright.sim.faults.bounds import TICK_S, gate_s, start_up_s, watchdog_s
from heatwright.sim.faults.fault import Fault, Trip, harmless, tripping
from heatwright.sim.faults.records import Edge
from heatwright.sim.faults.world import Site, World

STACK_POINTER = 0x5D
"""Address of SPL and SPH in the data space, the same in every simulated processor."""
INTERRUPTS_ON, INTERRUPTS_OFF = "__stop_program", "_exit"
LARGE_FLASH = 0x20000
"""With more flash than this, bytes, a return address has three bytes."""
WATCH_S = 30.0
GLANCES, GLANCE_S = 9, 0.001
"""Number and interval of tries to find the program asleep: together less than a tick."""


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of any processor."""
    trip = Trip(("watchdog_reset",), watchdog_s(site))
    for name, entry, off_s in (
        ("hung_main_loop", INTERRUPTS_ON, gate_s()),
        ("hung_with_interrupts_off", INTERRUPTS_OFF, trip.allowed_s),
    ):
        hangs = tripping(site, name, partial(hang, entry=entry), trip)
        yield replace(hangs, off_within_s=off_s, all_off=True)
    trip = Trip(("brown_out",), start_up_s(site))
    resets = tripping(site, "brown_out", lambda world: world.device.avr.reset("brown_out"), trip)
    yield replace(resets, off_within_s=0.0, all_off=True)
    yield harmless(
        site,
        "reset_button",
        lambda world: world.device.avr.reset("external"),
        WATCH_S,
        off_through_reset,
    )
    yield harmless(site, "power_cut", lambda world: world.power_cut(), WATCH_S, stays_off)


def hang(world: World, entry: str) -> None:
    """Make the sleeping program hang: overwrite its return address.

    If the program is busy at the end of a step of time, this happens when it next sleeps. Raises
    ValueError if it does not sleep within a tick.
    """
    for _ in range(GLANCES):
        if _redirected(world, entry):
            return
        world.device.avr.run(GLANCE_S)
    raise ValueError("The program did not sleep within a tick: it hangs, or still starts up.")


def _redirected(world: World, entry: str) -> bool:
    avr, program = world.device.avr, world.device.elf
    size = 3 if world.site.controller.board.flash_bytes > LARGE_FLASH else 2
    main, target = program.function("main"), program.symbols[entry]
    pointer = int.from_bytes(avr.read_ram(STACK_POINTER, 2), "little")
    for place in range(pointer + 1, pointer + 17):
        address = 2 * int.from_bytes(avr.read_ram(place, size), "big")
        if main.start < address < main.end:
            avr.write_ram(place, (target // 2).to_bytes(size, "big"))
            return True
    return False


def stays_off(world: World) -> str:
    """Check that a loop that does not start on its own has been off since the power came back."""
    if world.site.facts.starts_enabled:
        return ""
    last_s = world.heater.last_on_s(world.power_on_s)
    return "" if last_s is None else f"the heater was on at {last_s:.3f} s, after power-on"


def off_through_reset(world: World) -> str:
    """Check that the heater went off at the reset, and that its pin was then driven to off."""
    resets, avr = world.device.take_resets(), world.device.avr
    if len(resets) != 1:
        return f"there were {len(resets)} resets, not one"
    reset_s = world.now_s - avr.time_s + int(resets["cycle"][0]) / avr.clock_hz
    world.device.feed()
    after = world.heater.since(reset_s)
    return "" if _goes_off(after, reset_s) else "the heater's pin was not driven off after reset"


def _goes_off(edges: list[Edge], reset_s: float) -> bool:
    """Whether the resistor pulls the pin off at the reset, and the processor within a tick."""
    if len(edges) < 2 or edges[0].on or edges[0].driven or edges[0].time_s > reset_s:
        return False
    return not edges[1].on and edges[1].driven and edges[1].time_s < reset_s + TICK_S
