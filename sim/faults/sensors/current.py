"""Faults of what measures a heater's current: its line is torn, shorted, or its output stands."""

from __future__ import annotations

from collections.abc import Iterator
from typing import cast

from heatwright.sim.circuits import Wiring, reference_v
from heatwright.sim.faults import starts
from heatwright.sim.faults.bounds import TICK_S, reading_s, steps
from heatwright.sim.faults.fault import Act, Fault, Trip
from heatwright.sim.faults.trips import LONGEST_S
from heatwright.sim.faults.world import Condition, Site, World
from heatwright.sim.sensors.current import CurrentProbe
from heatwright.spec import Current, CurrentSensor, DigitalOutput, Loop, PwmOutput, full_a

JUDGED_S = 0.5
"""How long a current must be wrong to be a fault, where that is five steps at least."""
FEWEST_STEPS = 5
IDLE_SHARE = 0.05
IDLE_STEPS = 3
CODES = 1024


def faults(site: Site) -> Iterator[Fault]:
    """Yield what applies to the sensor of the heater's current."""
    lasting_s = current_s(site.loop)
    yield Fault(
        "current_sensor_torn",
        lambda: starts.heating(site),
        _wire(Wiring(opened=True)),
        _wire(Wiring()),
        trip=Trip(("no_current",), lasting_s, _asks(2 * idle_a(site)), LONGEST_S),
        again=Trip(("no_current",), lasting_s, _asks(2 * idle_a(site)), LONGEST_S),
    )
    yield Fault(
        "current_sensor_at_supply",
        lambda: starts.heating(site),
        _wire(Wiring(pin="high")),
        _wire(Wiring()),
        trip=Trip(("over_current",), reading_s(site.loop)),
        again=Trip(("over_current",), reading_s(site.loop)),
    )
    if site.has_operator:
        yield Fault(
            "current_sensor_stands",
            lambda: starts.heating(site),
            _stand,
            _let_go,
            trip=Trip(("current_while_off",), lasting_s, _is_off, LONGEST_S),
        )


def current_s(loop: Loop) -> float:
    """Bound the time that a current takes to be a fault: STEPS(0.5 s), five at least, steps."""
    count = max(FEWEST_STEPS, steps(JUDGED_S, loop))
    return (count + 1) * loop.period_s + TICK_S


def idle_a(site: Site) -> float:
    """Return the current that is none, A (docs/control.md, "Protections")."""
    sensor = cast("CurrentSensor", site.controller.sensors[_current(site).sensor])
    step_a = reference_v(sensor, site.controller.board) / CODES / sensor.scale_v_per_a
    return max(IDLE_SHARE * _current(site).nominal_a, IDLE_STEPS * step_a)


def _current(site: Site) -> Current:
    heater = cast("DigitalOutput | PwmOutput", site.controller.outputs[site.loop.heater])
    return cast("Current", heater.current)


def _probe(world: World) -> CurrentProbe:
    return cast("CurrentProbe", world.device.sensors[_current(world.site).sensor])


def _wire(wiring: Wiring) -> Act:
    def act(world: World) -> None:
        _probe(world).wiring = wiring

    return act


def _asks(least_a: float) -> Condition:
    """Whether the heater is asked for so much current."""

    def condition(world: World) -> bool:
        heater = world.site.controller.outputs[world.site.loop.heater]
        whole_a = full_a(cast("PwmOutput", heater)) or 0.0
        return world.loop("duty_percent") / 100 * whole_a >= least_a

    return condition


def _stand(world: World) -> None:
    """Let the sensor say on and on what it says of the heater now, and cool down."""
    world.until(lambda now: _probe(now).amperes >= 2 * idle_a(now.site), LONGEST_S)
    _probe(world).stands = True
    world.set_setpoint(starts.setpoints_c(world.site)[0])


def _let_go(world: World) -> None:
    _probe(world).stands = False


def _is_off(world: World) -> bool:
    return world.loop("duty_percent") == 0.0
