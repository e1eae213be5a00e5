"""Which loops have LEDs, and what these show."""

from heatwright.spec.commands import placed
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import Indicators


def shown_loop(controller: Controller, indicators: Indicators) -> str:
    """Name the loop that LEDs show: the one they name, otherwise the only one."""
    return next(iter(controller.loops)) if indicators.loop is None else indicators.loop


def indicated(controller: Controller, loop_name: str) -> bool:
    """Return whether LEDs show a loop."""
    return bool(shown_meanings(controller, loop_name))


def shown_meanings(controller: Controller, loop_name: str) -> frozenset[str]:
    """Collect what LEDs show of a loop."""
    return frozenset(
        meaning
        for each in placed(controller, Indicators).values()
        if shown_loop(controller, each) == loop_name
        for meaning in each.leds.values()
    )
