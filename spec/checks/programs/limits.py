"""Programs against the loop's protections and its counters."""

from collections.abc import Iterator

from heatwright.spec.checks.finding import Finding, Findings, loop_sensors
from heatwright.spec.checks.loops.timing import countable, time_fits
from heatwright.spec.controller import Controller
from heatwright.spec.loops import MOST_STEPS, Loop
from heatwright.spec.problems import Path
from heatwright.spec.programs import Programs
from heatwright.spec.quantity import about, number, rounded_up

MOST_COUNTED = 16_777_215
"""Maximum number of steps that single precision counts one by one: 2²⁴ − 1."""

_HOLD_BACK: Path = ("programs", "hold_back")


def _programmed_loop(controller: Controller) -> Iterator[tuple[str, Loop, Programs]]:
    """Yield the loop of the programs, if it is defined and its period is whole ticks."""
    programs = controller.programs
    for name, loop in countable(controller):
        if programs is not None and programs.loop == name:
            yield name, loop, programs


def hold_back_before_runaway(controller: Controller) -> Findings:
    """Check that the clock waits before the deviation trips a runaway rule.

    A kiln that cools slower than its program stays above the setpoint; a kiln with too little power
    stays below.
    """
    for name, loop, programs in _programmed_loop(controller):
        rule = loop.protection.runaway
        if rule is None:
            continue
        path: Path = ("loops", name, "protection", "runaway")
        if programs.hold_back is None:
            yield Finding(
                _HOLD_BACK,
                "the program's clock never waits, so a machine slower than the program departs "
                "from the setpoint, and rule runaway trips",
                "Write hold_back: 10 K, or runaway: off in protection",
                (path,),
            )
            continue
        within_k = programs.hold_back.within_k
        for key, limit_k in (("above", rule.above_k), ("below", rule.below_k)):
            if limit_k is not None and within_k >= limit_k:
                yield Finding(
                    _HOLD_BACK,
                    f"the program waits only beyond {number(within_k)} K, but rule runaway trips "
                    f"{number(limit_k)} K {key} the setpoint",
                    f"Use less than {number(limit_k)} K, or a larger {key}",
                    ((*path, key),),
                )


def targets_can_be_reached(controller: Controller) -> Findings:
    """Check that `reached_within` is above the loop's steady error and below `hold_back`."""
    names = {name for name, _, _ in _programmed_loop(controller)}
    for name, loop, sensor in loop_sensors(controller):
        programs = controller.programs
        if name not in names or programs is None:
            continue
        path: Path = ("programs", "reached_within")
        reached_k = programs.reached_within_k
        rests = {
            "the sensor's step at the highest setpoint": sensor.step_at_k(
                loop.setpoint.maximum_c, controller.board.mcu
            ),
            "the band in which the loop may settle": loop.algorithm.rests_within_k,
        }
        what, widest_k = max(rests.items(), key=lambda item: item[1])
        if reached_k <= widest_k:
            yield Finding(
                path,
                f"{number(reached_k)} K is not above {what}, {about(widest_k)} K: a target might "
                "never be reached",
                f"Use more than {rounded_up(widest_k)} K",
                (("loops", name), ("sensors", loop.sensor)),
            )
        elif programs.hold_back is not None and reached_k >= programs.hold_back.within_k:
            within = number(programs.hold_back.within_k)
            yield Finding(
                path,
                f"{number(reached_k)} K is not below hold_back, {within} K: at a reached target "
                "the clock would still wait",
                f"Use less than {within} K",
                (_HOLD_BACK,),
            )


def program_times_fit(controller: Controller) -> Findings:
    """Check that a program's times are at least a period, and fit its counters."""
    for name, loop, programs in _programmed_loop(controller):
        for path, seconds, most in _times(programs):
            yield from time_fits(path, seconds, name, loop, most)


def _times(programs: Programs) -> Iterator[tuple[Path, float, int]]:
    """List the times of programs that are counted in steps: path, s, and the most steps."""
    held = programs.hold_back
    if held is not None:
        yield (*_HOLD_BACK, "limit"), held.limit_s, MOST_STEPS
    yield ("programs", "save_every"), programs.save_every_s, MOST_STEPS
    for index, program in enumerate(programs.stored):
        for place, segment in enumerate(program.segments):
            path: Path = ("programs", "stored", index, "segments", place)
            if segment.over_s is not None:
                yield (*path, "over"), segment.over_s, MOST_COUNTED
            elif segment.hold_s is not None:
                yield (*path, "hold"), segment.hold_s, MOST_COUNTED
