"""What the current of a heater tells: which rule has to trip, and when."""

from __future__ import annotations

from heatwright.sim.circuits import reference_v
from heatwright.sim.faults.bounds import TICK_S, steps
from heatwright.sim.faults.fault import Trip
from heatwright.sim.faults.trips import LONGEST_S
from heatwright.sim.faults.world import STEP_S, Site, World
from heatwright.sim.reference.limiter import (
    FEWEST_STEPS,
    IDLE_ADC_STEPS,
    IDLE_SHARE,
    LASTING_S,
)
from heatwright.spec import Current, CurrentSensor, DigitalOutput, PwmOutput, full_a

NONE_SHARE = 0.5
CODES = 1024
SOFT_START = 0.25


class Measured:
    """A heater whose current is measured, in amperes.

    full_a -- while it is on; mean_a -- at a duty of 100 %; idle_a -- what counts as a current at
    all; over_a -- what trips.
    """

    def __init__(self, output: DigitalOutput | PwmOutput, current: Current, step_a: float) -> None:
        self.full_a = full_a(output) or 0.0
        self.mean_a = (output.power_w or 0.0) / (output.supply_v or 1.0)
        self.idle_a = max(IDLE_SHARE * current.nominal_a, IDLE_ADC_STEPS * step_a)
        self.over_a = current.over_a
        self.limit_a = current.limit_a


def measured(site: Site) -> Measured | None:
    """Return the loop's heater in amperes; None if its current is not measured."""
    output = site.controller.outputs[site.loop.heater]
    if not isinstance(output, DigitalOutput | PwmOutput) or output.current is None:
        return None
    sensor = site.controller.sensors[output.current.sensor]
    assert isinstance(sensor, CurrentSensor)  # noqa: S101 - the language allows no other
    return Measured(output, output.current, current_step_a(site, sensor))


def current_step_a(site: Site, sensor: CurrentSensor) -> float:
    """Return one step of the ADC, A."""
    return reference_v(sensor, site.controller.board) / CODES / sensor.scale_v_per_a


def lasting_current_s(site: Site) -> float:
    """A current is wrong for so many steps; the machine tells it one of its own steps late."""
    lasting = max(FEWEST_STEPS, steps(LASTING_S, site.loop))
    return (lasting + 1) * site.loop.period_s + TICK_S + STEP_S


def no_current(site: Site, share: float = 0.0) -> Trip | None:
    """The heater is on, and only this share of its current flows."""
    heater = measured(site)
    if heater is None or share >= NONE_SHARE:
        return None

    def due(world: World) -> bool:
        return world.loop("duty_percent") / 100 * heater.mean_a >= 2 * heater.idle_a

    return Trip(("no_current",), lasting_current_s(site), due, LONGEST_S)


def current_while_off(site: Site, share: float = 1.0, *others: str) -> Trip | None:
    """The heater is off, and this share of its full current flows.

    others -- rules that may be sooner.
    """
    heater = measured(site)
    if heater is None or share * heater.full_a < 2 * heater.idle_a:
        return None
    over = ("over_current",) if share * heater.full_a >= heater.over_a else ()
    rules = ("current_while_off", *over, *others)

    def due(world: World) -> bool:
        return world.loop("duty_percent") == 0

    return Trip(rules, lasting_current_s(site), due, LONGEST_S)
