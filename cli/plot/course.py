"""The readings of a loop in a recorded log."""

import re
from dataclasses import replace

import numpy as np

from heatwright.cli.identify.asked import Asked
from heatwright.cli.plot.hearing import Reading, known
from heatwright.sim.identify import Log, Unusable, read_log, tabled
from heatwright.sim.trace import Series

_SETPOINT = re.compile(r"set.?point|target", re.IGNORECASE)
_PLOTTED = 1
"""The column of the setpoint in the lines of the firmware's plotter."""


def course_of(asked: Asked, data: bytes) -> list[Reading]:
    """Read a log as identify does, with the setpoint if it has one. Raises Unusable."""
    log = read_log(data)
    roles, scales = asked.roles(log)
    full_w = scales.power_w or 1.0
    times_s, readings_c, powers_w = tabled(log, roles, replace(scales, power_w=full_w), [])
    timed = np.isfinite(times_s)
    if not timed.any():
        raise Unusable("has no column of times")
    rows = zip(
        (times_s - times_s[timed][0])[timed].tolist(),
        readings_c[timed].tolist(),
        _setpoints(asked, log)[timed].tolist(),
        (100 * powers_w / full_w)[timed].tolist(),
        strict=True,
    )
    return [Reading(time_s, *map(known, others)) for time_s, *others in rows]


def _setpoints(asked: Asked, log: Log) -> Series:
    names = [name for name in log.names if _SETPOINT.search(name)]
    if asked.reported is not None and (target := f"{asked.reported[0]} target") in names:
        names = [target]
    own = [name for name in names if name.startswith(f"{asked.loop}.")] or names
    if own:
        return log.values[:, log.names.index(own[0])]
    if not log.names and asked.plotter is not None:
        return log.values[:, _PLOTTED]
    return np.full(len(log.values), np.nan)
