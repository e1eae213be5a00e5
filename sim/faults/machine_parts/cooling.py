"""Check the cooler while a fault is latched: it must be on if the reading is hot or invalid."""

from heatwright.sim.faults.world import World
from heatwright.sim.reference.loop import FAULT_COOLING_ABOVE_C

COOLED_ABOVE_C = float(FAULT_COOLING_ABOVE_C)
"""Under a fault the cooler is off only if a valid reading is below (docs/control.md, "Cooler")."""


def complaint(world: World) -> str:
    """Return what is wrong with the cooler's state under a latched fault, or ""."""
    cooler = world.site.loop.cooler
    if cooler is None or world.until(_is_right, _held_s(world, cooler)):
        return ""
    runs = "on" if world.device.outputs[cooler].on else "off"
    return f"cooler {cooler} is wrongly {runs} at {world.loop('temperature_c'):.1f} °C"


def _held_s(world: World, cooler: str) -> float:
    """Return how long minimum times, and the wait for the next step, may delay the cooler, s."""
    output = world.site.controller.on_off_output(cooler)
    return world.site.loop.next_step_s(max(output.minimum_on_s, output.minimum_off_s))


def _is_right(world: World) -> bool:
    """Whether the cooler runs if it must, by the reading, which is checked elsewhere."""
    must = bool(world.loop("reading_status")) or world.loop("temperature_c") >= COOLED_ABOVE_C
    return bool(world.device.outputs[world.site.loop.cooler or ""].on == must)
