"""Whether a loop goes by limits that may be, whatever its settings have become."""

from collections.abc import Iterator
from itertools import product
from math import inf, nan

import numpy as np
from host_scale import scale_of

from heatwright.sim.host import Host
from heatwright.sim.host.firmware import INPUT
from heatwright.sim.reference.algorithms.pid import limits_of, may_limit
from heatwright.sim.reference.inputs import Limits
from heatwright.sim.reference.numbers import Single
from heatwright.spec import Pid

MILD_C = 30.0
LEAST_RANGE = 1.0
"""Of the output, above its minimum."""


def limits_problem(host: Host) -> str:
    """Say which settings the next step does not take, or takes although they cannot be."""
    ((name, loop),) = host.build.controller.loops.items()
    algorithm, library = loop.algorithm, host.library
    if not isinstance(algorithm, Pid) or not algorithm.limits_adjustable:
        return ""
    inputs = np.zeros(1, INPUT)
    inputs["reading_raw"] = scale_of(host.build.controller).code(MILD_C)
    host.erase()
    host.power_up()
    for limits in doubtful_limits(algorithm):
        sound = may_limit(algorithm, limits)
        if getattr(library, f"settings_may_limit_{name}")(*limits) != sound:
            return f"{limits}: they {'may' if sound else 'may not'} be"
        for member, limit in zip(Limits._fields, limits, strict=True):
            setattr(library.settings, f"{name}_{member}_percent", limit)
        library.fault.code, library.fault_complement = 0, 255
        row = host.run(inputs).states[0]
        wanted = limits if sound else limits_of(algorithm)
        found = Limits(*(row[f"{member}_percent"] for member in Limits._fields))
        kept = [getattr(library.settings, f"{name}_{each}_percent") for each in Limits._fields]
        if not found == Limits(*map(Single, kept)) == wanted:
            return f"{limits} become {found}, and in the settings {kept}"
    return ""


def doubtful_limits(algorithm: Pid) -> Iterator[Limits]:
    """Limits at each bound and just beside it, in any order, and what is no number."""
    least, most, full = limits_of(algorithm)
    floor = Single(algorithm.output.minimum_percent + LEAST_RANGE)
    middle = Single((least + most) / 2)
    places = (
        (*_about(least), middle, *_about(most), nan, -inf),
        (*_about(least), middle, *_about(most), nan, inf),
        (*_about(floor), *_about(least), middle, *_about(full), nan, inf),
    )
    for limits in product(*places):
        yield Limits(*map(Single, limits))


def _about(bound: Single) -> tuple[Single, ...]:
    return np.nextafter(bound, Single(-200)), bound, np.nextafter(bound, Single(200))
