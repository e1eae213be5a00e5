"""The procedure sees what is wrong: each finding is provoked once."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import pytest
from fault_machines import faults_of

from heatwright.sim.faults import Fault, FaultResult, try_fault
from heatwright.sim.faults.bounds import TICK_S
from heatwright.sim.faults.world import World


def found(spoil: Callable[[Fault], Fault] = lambda fault: fault) -> FaultResult:
    return try_fault(spoil(faults_of("chamber")["unplugged"]))


def tripping(fault: Fault, **changes: Any) -> Fault:
    """With another expectation of what trips."""
    assert fault.trip is not None
    return replace(fault, trip=replace(fault.trip, **changes))


def making(fault: Fault, spoil: Callable[[World], object], **changes: Any) -> Fault:
    """With something done to the world before it begins."""

    def make() -> World:
        world = fault.make()
        spoil(world)
        return world

    return replace(fault, make=make, **changes)


def never_mended(fault: Fault) -> Fault:
    """The chip stays off the line through a loss of power."""

    def spoil(world: World) -> None:
        power_cut = world.power_cut

        def cut(off_s: float = 1.0, *, undefined: int = 0xFF) -> None:
            power_cut(off_s, undefined=undefined)
            fault.cause(world)

        world.power_cut = cut  # type: ignore[method-assign]

    return making(fault, spoil, cure=lambda _: None)


SPOILT: dict[str, Callable[[Fault], Fault]] = {
    "tripped after 4.9.. s, not within 0.500 s": partial(tripping, allowed_s=0.5),
    "sensor_no_answer tripped, not over_temperature": partial(
        tripping, rules=("over_temperature",)
    ),
    "sensor_no_answer tripped for no reason": partial(replace, trip=None, watch_s=10.0),
    "^nothing tripped$": partial(replace, cause=lambda _: None),
    "its condition was not met within 1 s": lambda fault: replace(
        tripping(fault, due=lambda _: False, due_within_s=1.0), cause=lambda _: None
    ),
    "heater off after 0.9.. s, not within 0.010 s": partial(replace, off_within_s=TICK_S),
    "tripped again although|sensor_no_answer is latched after its ack": never_mended,
    "sensor_no_answer was latched before it began": lambda fault: making(
        fault, lambda world: (fault.cause(world), world.run(10.0))
    ),
    "the judge complains": partial(replace, judge=lambda _: "the judge complains"),
}


@pytest.mark.parametrize("finding", SPOILT)
def test_it_is_found(finding: str) -> None:
    result = found(SPOILT[finding])
    assert not result.passed
    assert re.search(finding, result.detail)


def test_a_heater_that_is_on_after_the_trip_is_found() -> None:
    """The pin is forced on as a short beside it would, ten ticks after the trip."""

    def cause(world: World) -> None:
        world.device.sensors["air"].unplug()  # type: ignore[attr-defined]
        world.until(lambda now: now.fault != 0, 10.0)
        world.run(0.1)
        world.device.avr.pins.drive("PD3", "high")
        world.run(0.1)
        world.device.avr.pins.drive("PD3", None)

    assert "a heater was on 0." in found(partial(replace, cause=cause)).detail


def test_json() -> None:
    near_s = partial(pytest.approx, abs=1)
    assert found().as_json() == {
        "fault": "unplugged", "rule": "sensor_no_answer", "expected": ["sensor_no_answer"],
        "tripped_after_s": near_s(5), "allowed_s": 6.01, "heater_off_after_s": near_s(1),
        "peak": pytest.approx(65, abs=1), "passed": True, "detail": "",
    }  # fmt: skip
