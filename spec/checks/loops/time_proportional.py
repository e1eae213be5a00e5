"""Time-proportional outputs: steps of whole ticks, enough of them, pulses that fit the window."""

import math
from collections.abc import Iterator

from heatwright.spec.board.pwm_timers import FEWEST_COUNTS
from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.loops.timing import is_ticks, whole_ticks
from heatwright.spec.controller import Controller
from heatwright.spec.loops import MOST_STEPS
from heatwright.spec.outputs import TimeProportionalOutput
from heatwright.spec.quantity import duration

MAINS_PERIOD_S = 0.02
"""Length of one period of 50 Hz mains, s."""


def _outputs(controller: Controller) -> Iterator[tuple[str, TimeProportionalOutput]]:
    """List the time-proportional outputs with a valid resolution: others cannot be checked."""
    for name, output in controller.outputs.items():
        if isinstance(output, TimeProportionalOutput) and is_ticks(output.resolution_s):
            yield name, output


def resolution_is_ticks(controller: Controller) -> Findings:
    """Find resolutions that are no whole number of ticks."""
    for name, output in controller.outputs.items():
        if isinstance(output, TimeProportionalOutput):
            yield from whole_ticks(("outputs", name, "resolution"), output.resolution_s)


def _steps(output: TimeProportionalOutput, seconds: float) -> float:
    return round(seconds * 1000, 6) / round(output.resolution_s * 1000, 6)


def window_has_steps(controller: Controller) -> Findings:
    """Find windows with too few or too many steps of power, or with a fraction of a step."""
    for name, output in _outputs(controller):
        path = ("outputs", name, "window")
        because_of = (("outputs", name, "resolution"),)
        steps = _steps(output, output.window_s)
        resolution = duration(output.resolution_s)
        if steps < FEWEST_COUNTS:
            yield Finding(
                path,
                f"{duration(output.window_s)} is shorter than {FEWEST_COUNTS} steps of "
                f"{resolution}, so one step is more than 1 % of the power",
                f"Use at least {duration(FEWEST_COUNTS * output.resolution_s)}",
                because_of,
            )
        elif steps > MOST_STEPS:
            yield Finding(
                path,
                f"{duration(output.window_s)} is longer than {MOST_STEPS} steps of {resolution}",
                "Use a shorter window or a coarser resolution",
                because_of,
            )
        elif not steps.is_integer():
            nearest_s = max(round(steps), FEWEST_COUNTS) * output.resolution_s
            yield Finding(
                path,
                f"{duration(output.window_s)} is not a multiple of the resolution of {resolution}",
                f"Use {duration(nearest_s)}",
                because_of,
            )


def spread_leaves_no_dc(controller: Controller) -> Findings:
    """Find steps of a spread output that are half periods of the mains.

    Half waves of one sign would be direct current, which damages transformers. A step of 20 ms is
    one period of 50 Hz; at 60 Hz it is 1.2 periods, and its phase repeats every 100 ms.
    """
    for name, output in _outputs(controller):
        odd_ms = round(output.resolution_s * 1000) % round(MAINS_PERIOD_S * 1000)
        if output.distribution == "spread" and odd_ms:
            more_s = math.ceil(output.resolution_s / MAINS_PERIOD_S) * MAINS_PERIOD_S
            yield Finding(
                ("outputs", name, "resolution"),
                f"{duration(output.resolution_s)} is no whole number of periods of 50 Hz mains: "
                "spread over the window, half waves of one sign would be missing",
                f"Use {duration(round(more_s, 2))}, or distribution: burst",
                (("outputs", name, "distribution"),),
            )


def spread_has_no_rests(controller: Controller) -> Findings:
    """Find a shortest pulse or pause of a spread output: one step is both, so neither is set."""
    for name, output in _outputs(controller):
        for key, seconds in (
            ("minimum_on", output.minimum_on_s),
            ("minimum_off", output.minimum_off_s),
        ):
            if output.distribution == "spread" and seconds:
                yield Finding(
                    ("outputs", name, key),
                    "with distribution: spread, the shortest pulse and pause are the resolution",
                    f"Delete it, or replace it by resolution: {duration(seconds)}",
                    (("outputs", name, "distribution"),),
                )


def pulses_fit(controller: Controller) -> Findings:
    """Find shortest pulses and pauses that do not fit the window, or are no multiple of a step."""
    for name, output in _outputs(controller):
        together_s = output.minimum_on_s + output.minimum_off_s
        if together_s > output.window_s:
            longer = "minimum_on" if output.minimum_on_s >= output.minimum_off_s else "minimum_off"
            yield Finding(
                ("outputs", name, longer),
                f"the shortest pulse and the shortest pause, {duration(together_s)} together, do "
                f"not fit into the window of {duration(output.window_s)}",
                "Shorten them or lengthen the window",
                (("outputs", name),),
            )
        for key, seconds in (
            ("minimum_on", output.minimum_on_s),
            ("minimum_off", output.minimum_off_s),
        ):
            if not _steps(output, seconds).is_integer():
                yield Finding(
                    ("outputs", name, key),
                    f"{duration(seconds)} is not a multiple of the resolution of "
                    f"{duration(output.resolution_s)}",
                    f"Use {duration(round(_steps(output, seconds)) * output.resolution_s)}",
                    (("outputs", name, "resolution"),),
                )
