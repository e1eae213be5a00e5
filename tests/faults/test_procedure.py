"""The procedure sees what is wrong: each finding is provoked once."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from heatwright.sim.faults import Fault, FaultResult, catalogue, try_fault
from heatwright.sim.faults.bounds import TICK_S
from heatwright.sim.faults.fault import Trip
from heatwright.sim.faults.world import Site, World

Spoil = Callable[[Fault], Fault]


def found(site: Site, name: str, spoil: Spoil) -> FaultResult:
    (fault,) = [each for each in catalogue(site.controller, site.program) if each.id == name]
    return try_fault(spoil(fault))


def trip_of(fault: Fault) -> Trip:
    assert fault.trip is not None
    return fault.trip


def too_soon(fault: Fault) -> Fault:
    return replace(fault, trip=replace(trip_of(fault), allowed_s=0.5))


def another_rule(fault: Fault) -> Fault:
    return replace(fault, trip=replace(trip_of(fault), rules=("over_temperature",)))


def nothing_expected(fault: Fault) -> Fault:
    return replace(fault, trip=None, watch_s=10.0)


def without_cause(fault: Fault) -> Fault:
    return replace(fault, cause=lambda _: None)


def never_due(fault: Fault) -> Fault:
    trip = replace(trip_of(fault), due=lambda _: False, due_within_s=1.0)
    return replace(fault, cause=lambda _: None, trip=trip)


def off_sooner(fault: Fault) -> Fault:
    return replace(fault, off_within_s=TICK_S)


def never_mended(fault: Fault) -> Fault:
    return replace(fault, cure=lambda _: None, make=lambda: StaysUnplugged(fault.make()).world)


def latched_before(fault: Fault) -> Fault:
    def make() -> World:
        world = fault.make()
        fault.cause(world)
        world.run(10.0)
        return world

    return replace(fault, make=make)


def judged(fault: Fault) -> Fault:
    return replace(fault, judge=lambda _: "the judge complains")


class StaysUnplugged:
    """The chip stays off the line through a loss of power."""

    def __init__(self, world: World) -> None:
        self.world = world
        power_cut = world.power_cut

        def cut(off_s: float = 1.0, *, undefined: int = 0xFF) -> None:
            power_cut(off_s, undefined=undefined)
            world.device.sensors["air"].unplug()  # type: ignore[attr-defined]

        world.power_cut = cut  # type: ignore[method-assign]


@pytest.mark.parametrize(
    ("spoil", "finding"),
    [
        (too_soon, "tripped after 4.9.. s, not within 0.500 s"),
        (another_rule, "sensor_no_answer tripped, not over_temperature"),
        (nothing_expected, "sensor_no_answer tripped for no reason"),
        (without_cause, "^nothing tripped$"),
        (never_due, "its condition was not met within 1 s"),
        (off_sooner, "heater off after 0.9.. s, not within 0.010 s"),
        (never_mended, "tripped again although|sensor_no_answer is latched after its ack"),
        (latched_before, "sensor_no_answer was latched before it began"),
        (judged, "the judge complains"),
    ],
    ids=lambda each: getattr(each, "__name__", ""),
)
def test_it_is_found(site: Site, spoil: Spoil, finding: str) -> None:
    result = found(site, "unplugged", spoil)
    assert not result.passed
    with pytest.raises(AssertionError, match=finding):
        raise AssertionError(result.detail)


def test_a_heater_that_is_on_after_the_trip_is_found(site: Site) -> None:
    """The pin is forced on as a short beside it would, ten ticks after the trip."""

    def cause(world: World) -> None:
        world.device.sensors["air"].unplug()  # type: ignore[attr-defined]
        world.until(lambda now: now.fault != 0, 10.0)
        world.run(0.1)
        world.device.avr.pins.drive("PD3", "high")
        world.run(0.1)
        world.device.avr.pins.drive("PD3", None)

    result = found(site, "unplugged", lambda fault: replace(fault, cause=cause))
    assert "a heater was on 0." in result.detail


def test_json(site: Site) -> None:
    result = found(site, "unplugged", lambda fault: fault)
    assert result.as_json() == {
        "fault": "unplugged",
        "rule": "sensor_no_answer",
        "expected": ["sensor_no_answer"],
        "tripped_after_s": pytest.approx(5, abs=1),
        "allowed_s": 6.01,
        "heater_off_after_s": pytest.approx(1, abs=1),
        "peak": pytest.approx(65, abs=1),
        "passed": True,
        "detail": "",
    }
