"""Courses of readings, setpoints, commands and acknowledgements, of a few kinds of stretches."""

from random import Random
from typing import Any

import numpy as np
from courses import host_stretches_commanded as walks
from courses.host_reference import HOST_BAD, HOST_ONLY, Way, alone, fill_currents, ways_of
from courses.host_stretches import LONGEST, Stretch, Walk
from numpy.typing import NDArray

from heatwright.spec import Controller, facts_of

KINDS = (
    "hold", "drift", "reach", "rise_by", "jump", "miss", "lose", "noise", "wild", "setpoint",
    "zigzag", "leave", "swing",
)  # fmt: skip
COMMAND_KINDS = (
    "setpoint", "order", "manual", "gains", "gains", "off_and_on", "tune", "tune_in_part",
)  # fmt: skip
"""What else a course of a commanded loop is made of; on others they hold."""
SWITCH_KINDS = ("switch", "order_switched", "by_percent")
"""What a course of a switched loop is made of, besides."""
LOST_KINDS = ("silence",)  # where the master, or the host, may be lost, besides
ADJUSTING_KINDS = ("critical",)  # where the operator may move the critical temperature, besides
NUMBER_KINDS = ("numbers", "numbers")  # where keys set numbers of the algorithm, besides
LIMITING_KINDS = ("limits",)  # where a host may narrow the limits of integral and output, besides
CURRENT_KINDS = ("load", "load", "leak", "over", "no_scan")
"""Where the heater's current is measured, besides."""
OTHER_CODES = ("over", "leak")
"""Those of them whose codes are those of the current sensor of `host_specs`."""

RARE = 0.25  # share of the changes of what is monitored that may be a fault
OPEN = 0.2  # share of the time for which an input that pauses is open
LONG = 300  # steps without a reading that eight bits cannot count

LONG_SILENCE = [
    Stretch("setpoint", 1, 3), Stretch("leave", 3, 1), Stretch("lose", 1, 8),
    Stretch("drift", 3, 40, acknowledge=True),
]  # fmt: skip
"""The readings come back after more steps than eight bits can count."""

STANDING = [
    [
        Stretch("setpoint", 1, 3), Stretch("reach", 1, 1), Stretch("drift", 3, way),
        Stretch("hold", 300, 0),
    ]
    for way in (60, -60)
]  # fmt: skip
"""A slope fades away, from above and from below."""

LOWERED = [
    Stretch("setpoint", 1, 3), Stretch("swing", 10, 20, acknowledge=True),
    Stretch("zigzag", 12, 20, acknowledge=True), Stretch("setpoint", 1, 0), Stretch("reach", 2, 1),
]  # fmt: skip
"""A charged integral, the setpoint lowered, the temperature falling fast: the duty is at its
maximum although the error is negative."""


RISEN = [Stretch("setpoint", 3, 3), *(Stretch("rise_by", 3, value) for value in range(6))]
"""At full power, rises by what rules wait for to the bit."""


NARROWED = [
    [Stretch("limits", 14, value), *[Stretch("hold", 14, 0)] * 3, Stretch("limits", 14, 7 * value)]
    for value in range(6)
]
"""As much power as a host has left, for as long as that may last without a rise, and then other."""


def random_course(random: Random, stretches: int, kinds: tuple[str, ...]) -> list[Stretch]:
    return [
        _begun(random, random.choice(kinds))._replace(
            nudge=random.choice((-1, 0, 0, 1)), acknowledge=random.random() < 0.5
        )
        for _ in range(stretches)
    ]


def random_firing(random: Random, stretches: int) -> list[Stretch]:
    return [_begun(random, "start"), *random_course(random, stretches, walks.FIRING_KINDS)]


def _begun(random: Random, kind: str) -> Stretch:
    return Stretch(kind, random.randint(1, 14), random.randint(-200, 200))


def inputs_of(controller: Controller, course: list[Stretch]) -> NDArray[Any]:
    """The steps of a course; a failed reading leaves the code as it was, as the firmware does."""
    inputs = _walked(controller, course)
    fill_monitors(controller, Random(repr(course)), inputs)  # noqa: S311 - no secret
    fill_inputs(controller, Random(repr(course)), inputs)  # noqa: S311 - no secret
    if walks.current_of(controller):
        fill_currents({"": Way(controller)}, {"": inputs})
    return inputs


def _walked(controller: Controller, course: list[Stretch]) -> NDArray[Any]:
    ((name, _),) = controller.loops.items()
    walk: type[Walk] = (
        walks.ProgrammedWalk if facts_of(controller, name).programmed else walks.CommandedWalk
    )
    return walk(controller).inputs(course)


def fill_monitors(controller: Controller, random: Random, inputs: NDArray[Any]) -> None:
    """Let what is monitored become warm and cool, and now and then too hot, or not be heard."""
    given, only, left = 0, 0, 0
    for row in inputs if controller.monitors else ():
        if not left:
            bad = HOST_BAD + random.choice((1, 2, 17))
            rarely = (6, 7, 8, bad) if random.random() < RARE else ()
            given = random.choice((*range(6), bad, *rarely))
            only = random.randint(0, min(3, len(controller.monitors)))
            left = random.choice((1, 1, 2, 5))
            left = LONG if given == bad and random.random() < RARE / 3 else left
        left -= 1
        row["monitored"] = given + HOST_ONLY * only


def fill_inputs(controller: Controller, random: Random, inputs: NDArray[Any]) -> None:
    """Let the machine's inputs be open now and then: some that pause, seldom one that trips."""
    pausing = [not each.trips for each in controller.safety.inputs.values()]
    mask, left = 0, 0
    for row in inputs if pausing else ():
        if not left:
            mask = sum(
                (random.random() < (OPEN if pauses else OPEN / 10)) << number
                for number, pauses in enumerate(pausing)
            )
            left = random.choice((1, 2, 5, 20))
        left -= 1
        row["open_inputs"] = mask


def random_inputs(
    controller: Controller, random: Random, stretches: int
) -> dict[str, NDArray[Any]]:
    """Random courses of all loops in the same time; what is over sooner begins again."""
    courses = {}
    for name in controller.loops:
        sees = alone(controller, name)
        kinds = tuple(kind for kind in kinds_of(sees) if kind not in OTHER_CODES)
        courses[name] = _walked(sees, random_course(random, stretches, kinds))
    ticks = {name: round(100 * loop.period_s) for name, loop in controller.loops.items()}
    wanted = max(len(rows) * ticks[name] for name, rows in courses.items())
    most = min(max(len(rows), LONGEST) * ticks[name] for name, rows in courses.items())
    hasty = random.choice((0.0, 0.02, 0.5))
    inputs = {}
    for name, rows in courses.items():
        inputs[name] = again = np.resize(rows, min(wanted, most) // ticks[name])
        fill_monitors(alone(controller, name), random, again)
        taken = 0
        for row in again:
            row["acknowledge"] |= random.random() < hasty
            taken = row["reading_raw"] = taken if row["reading_status"] else row["reading_raw"]
    fill_currents(ways_of(controller), inputs)
    return inputs


def kinds_of(controller: Controller) -> tuple[str, ...]:
    """The kinds of stretches that a controller has something to answer to."""
    ((name, loop),) = controller.loops.items()
    kinds = KINDS + COMMAND_KINDS * (2 * facts_of(controller, name).commanded)
    kinds += SWITCH_KINDS * (2 * facts_of(controller, name).switched)
    kinds += LOST_KINDS * (2 * (loop.protection.master_lost_after_s is not None))
    kinds += walks.PROGRAM_KINDS * (3 * facts_of(controller, name).programmed)
    kinds += NUMBER_KINDS * (2 * bool(facts_of(controller, name).keyed_numbers))
    kinds += ADJUSTING_KINDS * (2 * loop.protection.maximum_adjustable)
    kinds += LIMITING_KINDS * (2 * controller.loops[name].algorithm.limits_adjustable)
    return kinds + CURRENT_KINDS * (2 * (walks.current_of(controller) is not None))
