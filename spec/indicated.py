"""The loops that have LEDs, and the states that these LEDs show."""

from heatwright.spec.commands import placed
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import Indicators


def shown_loop(controller: Controller, indicators: Indicators) -> str:
    """Name the loop that LEDs show: the loop of their key `loop`, otherwise the only loop."""
    return next(iter(controller.loops)) if indicators.loop is None else indicators.loop


def indicated(controller: Controller, loop_name: str) -> bool:
    """Return whether LEDs show a loop."""
    return bool(shown_meanings(controller, loop_name))


def shown_meanings(controller: Controller, loop_name: str) -> frozenset[str]:
    """Collect the states of a loop that LEDs show."""
    return frozenset(
        meaning
        for each in placed(controller, Indicators).values()
        if shown_loop(controller, each) == loop_name
        for meaning in each.leds.values()
    )
