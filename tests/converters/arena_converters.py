"""The converters' C before the mutation engine: a crucible's sensor and its wires."""

from collections.abc import Callable
from functools import partial
from random import Random

import test_converter_firmware as checks
import test_max31856_choice as choice
from rig.firmware import Firmware, Program, controller_of, on
from rig.sensors import Crucible, crucible

BROKEN = ("sensor_tip", "spi_tip")
SELECTABLE = crucible(
    "max31856",
    "mega2560",
    extra=", selectable: [K, S]",
    more="programs: {loop: crucible, points: 2, places: 1, "
    "stored: [{name: one, segments: [{hold: 1 h}]}]}\n"
    "interfaces: [{kind: nextion, loop: crucible}]",
)


def arena(name: str, text: str, *checks: Callable[[Crucible], str]) -> Firmware:
    bound = (_timed(check) for check in checks)
    bench = partial(Crucible, text)
    return Firmware(f"converters/{name}", Program(text), BROKEN, on(bench, *bound))


def _timed(check: Callable[[Crucible], str]) -> Callable[[Crucible], str]:
    """Look at the wires' timing behind a check."""

    def both(bench: Crucible) -> str:
        found = check(bench)
        timing = "the wires' timing" if bench.chip.port.violations else ""
        return found or timing

    return both


def any_word_problem(kind: str, bench: Crucible) -> str:
    judged, bits, often_zero = checks.ANSWERS[kind]
    drawn = checks.words(Random(7), bits, often_zero, 5)  # noqa: S311 - no secret
    return checks.answers_problem(bench, drawn, judged)


def each_register_problem(bench: Crucible) -> str:
    return checks.registers_problem(bench, checks.registers_said(0))


few_readings = partial(checks.reading_problem, count=7)
ARENAS: list[Firmware] = [
    arena("max31856", crucible("max31856", period_s=checks.SHORTEST_S), checks.set_up_problem,
          few_readings, checks.short_problem, each_register_problem),
    Firmware(
        "converters/max31856 chosen",
        Program(SELECTABLE),
        ("sensor_tip",),
        on(
            partial(choice.Cold, controller_of(SELECTABLE)),
            choice.test_it_is_taken_over_with_the_next_reading,
            choice.test_not_while_a_program_runs_or_waits,
            choice.test_not_when_it_is_switched_before_the_next_step_sees_it,
        ),
    ),
    *(
        arena(kind, crucible(kind), few_readings, checks.short_problem,
              partial(any_word_problem, kind))
        for kind in checks.ANSWERS
    ),
]  # fmt: skip
