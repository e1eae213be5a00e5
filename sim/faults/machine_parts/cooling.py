"""The cooler: never on together with the heater, and on while a fault is latched and it is hot."""

from __future__ import annotations

from heatwright.sim.faults.world import World
from heatwright.sim.reference.loop import FAULT_COOLING_ABOVE_C

COOLED_ABOVE_C = float(FAULT_COOLING_ABOVE_C)
"""A latched fault has the cooler on unless a reading is below (docs/control.md, "Cooler")."""


def complaint(world: World) -> str:
    """Check that the cooler does what a latched fault asks of it; "" if so, or if it has none."""
    cooler = world.site.loop.cooler
    if cooler is None or world.until(_is_right, _held_s(world, cooler)):
        return ""
    runs = "on" if world.device.outputs[cooler].on else "off"
    return f"{cooler} is {runs} at a reading of {world.loop('temperature_c'):.1f} °C"


def _held_s(world: World, cooler: str) -> float:
    """Return how long its minimum times, and a wait for the loop's next step, may keep it."""
    output = world.site.controller.on_off_output(cooler)
    return world.site.loop.next_step_s(max(output.minimum_on_s, output.minimum_off_s))


def _is_right(world: World) -> bool:
    return world.device.outputs[world.site.loop.cooler or ""].on == _has_to(world)


def _has_to(world: World) -> bool:
    """Whether the cooler must run, by what was read: that readings are true is judged apart."""
    return bool(world.loop("reading_status")) or world.loop("temperature_c") >= COOLED_ABOVE_C
