"""Whether a host build decides as the reference model does, over many fixed courses."""

from collections.abc import Collection, Mapping, Sequence
from functools import cache
from itertools import pairwise
from random import Random
from typing import Any, NamedTuple

import host_specs
import numpy as np
from courses import host_courses
from courses.host_reference import SLACK, TRIPPED_BY, TRIPPED_C, Expected, Way, first_difference
from courses.host_stretches import Stretch
from courses.host_stretches_commanded import CRITICAL_C, TUNINGS
from numpy.typing import NDArray

from heatwright.sim.host import Host
from heatwright.sim.host.firmware import HostHangs, Run

COURSES = 100
TUNED_COURSES = 30
TRIPPED_COURSES, TRIP_EVERY = 20, 11
FIRINGS = 100
ARRIVALS = [
    [Stretch("start", 1 + steps, value), Stretch("arrive", 8, place, nudge)]
    for steps in range(6)
    for value in (-64, 64)
    for place in range(4)
    for nudge in (-1, 0, 1)
]
"""Programs that go up or down to 33 °C and stay there: where that counts as reached."""
STRETCHES = 14


class _Course(NamedTuple):
    inputs: NDArray[Any]
    wanted: Expected
    tripped: Sequence[int] = ()
    """Steps before which a fault is latched and acknowledged, faster than a step."""


@cache
def _courses(name: str) -> list[tuple[list[Stretch], bool]]:
    """What is done, and whether a fault comes and goes between the steps."""
    controller = host_specs.spec_of(name).controller
    kinds, programmed = host_courses.kinds_of(controller), name in host_specs.PROGRAMMED
    courses = [
        host_courses.LONG_SILENCE, host_courses.LOWERED, host_courses.RISEN, *host_courses.STANDING,
    ]  # fmt: skip
    if name in host_specs.COMMANDED:
        courses += [
            *([Stretch("tune_by_hand", 1, number)] for number in range(len(TUNINGS))),
            *([Stretch("setpoint", 1, 4), Stretch("off_and_on", 3, each)] for each in (60, -60)),
            *([Stretch("tune", 1 + number % 6, number)] for number in range(TUNED_COURSES)),
        ]
    if "critical" in kinds:
        courses += [[Stretch("critical", 3, value)] for value in range(2 * len(CRITICAL_C))]
    drawn = range(COURSES // 4 if programmed else COURSES)
    if "limits" in kinds:
        courses += host_courses.NARROWED
    courses += [host_courses.random_course(Random(seed), STRETCHES, kinds) for seed in drawn]  # noqa: S311
    if programmed:
        firings = (host_courses.random_firing(Random(-seed), STRETCHES) for seed in range(FIRINGS))  # noqa: S311
        courses += [*ARRIVALS, *firings]
    tripped = ((course, True) for course in courses[-TRIPPED_COURSES:])
    return [*((course, False) for course in courses), *tripped]


@cache
def _fixed(name: str, number: int, kind: np.dtype[Any]) -> _Course:
    controller = host_specs.spec_of(name).controller
    course, trips = _courses(name)[number]
    inputs = host_courses.inputs_of(controller, course)
    tripped = range(len(inputs) % TRIP_EVERY, len(inputs), TRIP_EVERY) if trips else ()
    return _Course(inputs, Way(controller).expected(inputs, kind, tripped), tripped)


def run_problem(
    host: Host, inputs: NDArray[Any], wanted: Expected, tripped: Sequence[int] = ()
) -> str:
    """Say where the host differs from the reference from power-up on; empty if nowhere."""
    host.renew()
    try:
        difference = first_difference(_run(host, inputs, tripped), wanted)
    except HostHangs as problem:
        return str(problem)
    return difference or _totals_problem(host, [wanted])


def all_problem(
    host: Host, inputs: Mapping[str, NDArray[Any]], wanted: Mapping[str, Expected]
) -> str:
    host.renew()
    try:
        found = host.run_all(inputs)
    except HostHangs as problem:
        return str(problem)
    for name, run in found.items():
        if difference := first_difference(run, wanted[name]):
            return f"{name}, {difference}"
    return _totals_problem(host, wanted.values())


def _totals_problem(host: Host, wanted: Collection[Expected]) -> str:
    ticks = max(each.ticks for each in wanted)
    if host.world.ticks != ticks:
        return f"it took {host.world.ticks} ticks, not {ticks}"
    cooled = sum(each.cooler_ticks for each in wanted)
    if abs(host.world.cooler_ticks - cooled) > SLACK:
        return f"it cools for {host.world.cooler_ticks} ticks, not {cooled}"
    if host.world.both_on:
        return f"heater and cooler are on together for {host.world.both_on} ticks"
    return ""


def _run(host: Host, inputs: NDArray[Any], tripped: Sequence[int]) -> Run:
    parts = []
    for first, last in pairwise((0, *(each for each in tripped if each), len(inputs))):
        if first in tripped:
            host.library.fault_trip(TRIPPED_BY, TRIPPED_C)
            host.library.host_acknowledge()
        parts.append(host.run(inputs[first:last]))
    states, counts = (np.concatenate(each) for each in zip(*parts, strict=True))
    return Run(states, counts)


def prepare_control(host: Host, name: str) -> None:
    for number in range(len(_courses(name))):
        _fixed(name, number, host.type)


def control_problem(host: Host, name: str, most: int | None = None) -> str:
    """The same over the fixed courses, or over as many of them, from the last one on."""
    numbers = range(len(_courses(name)))[::-1][:most]
    for number in numbers:
        problem = run_problem(host, *_fixed(name, number, host.type))
        if problem:
            return f"course {number}, {problem}"
    return ""
