"""Timing of measured currents: how often they are read, and how their mean is formed."""

import math
from collections.abc import Iterator

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.sensing.currents import measured
from heatwright.spec.controller import Controller
from heatwright.spec.loops import Loop
from heatwright.spec.problems import Path
from heatwright.spec.quantity import duration, hertz, rounded_up
from heatwright.spec.sensing.conversion import TICK_S
from heatwright.spec.sensing.currents import FILTER_PULSES

LONGEST_PERIOD_S = 1.0
"""Longest period: a current is checked once a period, so a short circuit may last this long."""


def currents_in_time(controller: Controller) -> Findings:
    """Check that the period is short enough for a short circuit, and long enough for readings."""
    for each in measured(controller):
        for name, loop in _loops_of(controller, each.name):
            path: Path = ("loops", name, "period")
            because_of: tuple[Path, ...] = (("sensors", each.current.sensor), each.path)
            readings = each.sensor.oversample
            needed_s = round(readings * TICK_S, 2)
            settled_s = 2 * needed_s if each.current.limit_a and readings > 1 else needed_s
            if loop.period_s > LONGEST_PERIOD_S:
                yield Finding(
                    path,
                    f"the current of {each.name} is checked once a period, and a short circuit "
                    f"must not last {loop.told_period}",
                    f"Use at most {duration(LONGEST_PERIOD_S)}",
                    because_of,
                )
            elif not loop.has_time_for(needed_s):
                yield Finding(
                    path,
                    f"{loop.told_period} is shorter than the {readings} "
                    f"readings of {each.current.sensor}, one every 10 ms, which take "
                    f"{duration(needed_s)}",
                    f"Use at least {duration(settled_s)}, or a smaller oversample of that sensor",
                    because_of,
                )
            elif round(loop.period_s, 6) < settled_s:
                yield Finding(
                    ("sensors", each.current.sensor, "oversample"),
                    f"after a change of duty the current settles in the first half of the period "
                    f"of {loop.told_period}: some of the {readings} readings, which take "
                    f"{duration(needed_s)}, would come before",
                    f"Use at most {max(1, math.floor(round(loop.period_s / TICK_S / 2, 6)))}, or a "
                    f"period of at least {duration(settled_s)}",
                    ((*each.path, "limit"), path),
                )


def currents_can_be_smoothed(controller: Controller) -> Findings:
    """Find pulses, and filters, that are too slow to give a mean current in the time available."""
    simulation = controller.simulation
    for each in measured(controller):
        if not each.output.frequency_hz:
            continue
        for name, loop in _loops_of(controller, each.name):
            longest_s = loop.period_s / each.current.filter_parts
            within = "a third of " if each.current.filter_parts > 1 else ""
            because_of: tuple[Path, ...] = (("loops", name, "period"), each.path)
            needed_hz = FILTER_PULSES / longest_s
            if each.output.frequency_hz < needed_hz:
                yield Finding(
                    ("outputs", each.name, "frequency"),
                    f"the filter for the mean current needs {FILTER_PULSES} pulses in {within}the "
                    f"period of {loop.told_period}, and {hertz(each.output.frequency_hz)} gives "
                    "fewer",
                    f"Use at least {rounded_up(needed_hz)} Hz, or a longer period",
                    because_of,
                )
            sense = simulation.plant.sense.get(each.current.sensor) if simulation else None
            whole_s = math.floor(1000 * longest_s) / 1000
            if sense is not None and sense.lag_s > longest_s:
                yield Finding(
                    ("simulation", "plant", "sense", each.current.sensor, "lag"),
                    f"a filter of {duration(sense.lag_s)} does not follow the current within "
                    f"{within}a period of {loop.told_period}",
                    f"Use at most {duration(whole_s)}, or a longer period",
                    because_of,
                )


def _loops_of(controller: Controller, heater: str) -> Iterator[tuple[str, Loop]]:
    return ((name, loop) for name, loop in controller.loops.items() if loop.heater == heater)
