"""Whether a heater's current is watched and limited as in the reference, to the very limits."""

from collections.abc import Iterator
from math import inf, nan
from typing import Any

import numpy as np
from courses.host_stretches_commanded import current_of
from host_scale import scale_of
from numpy.typing import NDArray

from heatwright.sim.host import Host
from heatwright.sim.host.firmware import INPUT
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.protection.limiter import HALF, TWO, Limiter

RAWS = 1024
MILD_C = 30.0
LASTS = 60
"""Steps in which each pair stays: a limit rises to its end, and a fault would come."""
UPSETS = (nan, inf, 1e30)
"""What a bit that flips in RAM may make of the limit, and what is no duty."""


def current_problem(host: Host) -> str:
    """Say the first step after which they differ; empty if none."""
    controller = host.build.controller
    ((name, loop),) = controller.loops.items()
    current = current_of(controller)
    if current is None:
        return ""
    limiter = Limiter(controller, loop)
    members = [name for name, _ in limiter.members]
    inputs = np.zeros(1, INPUT)
    inputs["reading_raw"] = scale_of(controller).code(MILD_C)
    host.erase()
    host.power_up()
    sensor = controller.sensors[current.sensor]
    for applied, raw in at_limits(limiter, getattr(sensor, "oversample", 1)):
        inputs["current_raw"] = raw
        for step in range(LASTS):
            getattr(host.library, f"loop_{name}").duty_percent = applied
            host.library.fault.code, host.library.fault_complement = 0, 255
            row = host.run(inputs).states[0]
            limiter.measure(raw, applied)
            code = limiter.watch()
            wanted = [*limiter.values(), code]
            found = [row[f"current.{member}"] for member in members] + [row["fault.code"]]
            if found != wanted:
                return f"{applied} % at {raw}, step {step}: {found}, not {wanted}"
    return _upset(host, inputs, limiter) if "limit_percent" in members else ""


def _upset(host: Host, inputs: NDArray[Any], limiter: Limiter) -> str:
    """Say which wrong limit is not the right one again in the next step; empty if none."""
    parts = host.build.parts
    applied = Single(60)
    for upset in (None,) * LASTS + UPSETS:
        if upset is not None:
            getattr(host.library, f"current_{parts.heater}").limit_percent = upset
        getattr(host.library, f"loop_{parts.name}").duty_percent = applied
        host.library.fault.code, host.library.fault_complement = 0, 255
        row = host.run(inputs).states[0]
        limiter.measure(int(inputs["current_raw"][0]), applied)
        found = row["current.limit_percent"]
        if found != limiter.top_percent:
            return f"a limit of {upset} becomes {found}, not {limiter.top_percent}"
    return ""


def at_limits(limiter: Limiter, scale: int) -> Iterator[tuple[Single, int]]:
    """Duties and sums of codes: a few of all, and all at which a rule is met to the last bit."""
    duties = [Single(each) for each in (0, 1.5, 25, 60, 99, 100)]
    yield from ((duty, raw * scale) for duty in duties for raw in (0, 1, 40, 200, 600, RAWS - 1))
    yield from ((duty, 0) for duty in at(TWO * limiter.idle_a, limiter.amperes_per_percent))
    for raw in range(0, RAWS * scale, 7):
        amperes = limiter.amperes_of(raw)
        for duty in at(TWO * amperes, limiter.amperes_per_percent):
            if HALF * (duty * limiter.amperes_per_percent) == amperes:
                yield duty, raw


def at(due_a: Single, per_percent: Single) -> list[Single]:
    """The duty up to 100 % that makes a current due, to the last bit, if there is one."""
    near = Single(due_a / per_percent)
    tried = (near, np.nextafter(near, Single(0)), np.nextafter(near, Single(200)))
    return [duty for duty in tried if duty <= 100 and duty * per_percent == due_a][:1]
