"""Check a trial of the firmware against the reference model and the simulated machine.

The reference model gets the firmware's readings of every control step and must reach the same
state, bit for bit. So the first rule that trips in the model is the one whose condition was met
first, and the firmware has latched its fault in the same step. The readings must also equal the
temperatures of the sensors' tips, and the currents that flowed, unless the sensor is faulty.
"""

import math
from collections.abc import Collection, Iterator

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.circuits import current_v, reference_v
from heatwright.sim.faults.machine import blur_k
from heatwright.sim.faults.machine_parts.currents import CODES
from heatwright.sim.faults.world import World
from heatwright.sim.replay import replay_all
from heatwright.spec import RULES, facts_of
from heatwright.spec.board.timers import TICK_S

Numbers = NDArray[np.float64]

COUNTS = {
    "guard.heating_steps": "heating_failed",
    "guard.frozen_steps": "sensor_frozen",
    "current.none_steps": "no_current",
    "current.leak_steps": "current_while_off",
}
"""Members of a control step that count steps until a rule trips, and the rule's id."""


def counting(world: World) -> tuple[str, ...]:
    """Return the ids of the loop's rules that were counting steps in its last control step."""
    log = world.device.steps(world.site.loop_name)
    if not len(log):
        return ()
    row = log[-1]
    names = row.dtype.names or ()
    found = [rule for member, rule in COUNTS.items() if member in names and row[member]]
    if "guard.runaway_steps" in names and row["guard.runaway_steps"]:
        below = row["temperature_c"] < row["setpoint_c"]
        found.append("runaway_below" if below else "runaway_above")
    effort = world.site.loop.protection.effort
    if effort is not None and row["guard.effort_steps"]:
        least = effort.band.at(float(row["temperature_c"]))[1]
        found.append("effort_low" if row["guard.effort_percent"] < least else "effort_high")
    if row["missing"]:
        found.append(RULES[int(row["reading_status"])].id if row["reading_status"] else "")
    return tuple(each for each in found if each)


def complaints(world: World, lying: Collection[str], *, current_lies: bool) -> Iterator[str]:
    """Yield how the firmware differs from the reference model, or its readings from the machine.

    lying -- the loops and monitors whose sensors are faulty; current_lies -- whether a current
    sensor is faulty.
    """
    logs = {name: world.device.steps(name) for name in world.site.controller.loops}
    idle = [name for name, log in logs.items() if not len(log)]
    had_s = world.now_s - world.power_on_s
    late = [name for name in idle if had_s > world.site.controller.loops[name].periods_s(2)]
    if late:
        yield f"{' and '.join(late)} did no control step"
        return
    logs = {name: log for name, log in logs.items() if name not in idle}
    for name, played in replay_all(world.site.controller, logs).items():
        if played.mismatches:
            yield f"{name} differs from the reference model: {played.first[0]}"
        loop = world.site.controller.loops[name]
        if name not in lying:
            yield from _untrue(world, name, loop.sensor, "")
        for each, monitor in facts_of(world.site.controller, name).monitored.items():
            if f"monitor_{each}" not in lying:
                yield from _untrue(world, name, monitor.sensor, f"monitor_{each}.")
        if not current_lies:
            yield from _not_flowed(world, name)


def _untrue(world: World, name: str, sensor: str, prefix: str) -> Iterator[str]:
    """Compare each good reading with the tip's temperatures in the period and conversion before it.

    prefix -- begins the names of the sensor's members in the log of the loop that reads it.
    """
    controller = world.site.controller
    log = world.device.steps(name)
    status, has = log[f"{prefix}reading_status"], log[f"{prefix}has_reading"]
    good = log[(status == 0) & (has == 1)]
    single = f"{prefix}reading_c"
    read_c = good[single if single in (log.dtype.names or ()) else f"{prefix}temperature_c"]
    times_s, tips_c = world.told(sensor)
    thermometer = controller.thermometers[sensor]
    age_s = controller.loops[name].next_step_s(thermometer.conversion_s) + world.step_s
    if thermometer.clips_c is not None:
        tips_c = np.clip(tips_c, *thermometer.clips_c)
    spans = _spans(times_s, good["time_s"] - age_s, good["time_s"] + world.step_s)
    least_c, most_c = _extremes(tips_c, spans)
    readings_c, which = np.unique(read_c, return_inverse=True)  # most rows have equal readings
    blurs_k = [blur_k(controller, sensor, each) for each in readings_c.tolist()]
    off_k, found_c = thermometer.step_k + np.array(blurs_k)[which], read_c.astype(np.float64)
    is_true = (least_c - off_k <= found_c) & (found_c <= most_c + off_k)
    for row in np.flatnonzero(~is_true)[:1]:
        yield (
            f"{sensor} of {prefix.rstrip('.') or name} read {found_c[row]:.2f} °C at "
            f"{good['time_s'][row]:.2f} s, but its tip was at {least_c[row]:.2f} to "
            f"{most_c[row]:.2f} °C"
        )


def _spans(times_s: Numbers, since_s: Numbers, until_s: Numbers) -> NDArray[np.intp]:
    """Return for each time span the indices from the last value before it to the first after it."""
    first, last = np.searchsorted(times_s, since_s), np.searchsorted(times_s, until_s)
    return np.stack((np.maximum(0, first - 1), np.minimum(last + 1, len(times_s))), axis=1)


def _extremes(values: Numbers, spans: NDArray[np.intp]) -> tuple[Numbers, Numbers]:
    """Return the lowest and the highest value of each span."""
    if not len(spans):
        return np.empty(0), np.empty(0)
    padded = np.append(values, 0.0)  # so that a span may end with the last value
    least, most = (each.reduceat(padded, spans.ravel())[::2] for each in (np.minimum, np.maximum))
    return least, most


def _not_flowed(world: World, name: str) -> Iterator[str]:
    """Compare each reading of the heater's current with the real one, to one code of the ADC.

    A step takes the last complete sum of one code per tick, which began in the period before; the
    first one after a reset takes a sum of the start-up, whose end depends on the crystal.
    """
    controller, loop = world.site.controller, world.site.controller.loops[name]
    current = facts_of(controller, name).current
    if current is None:
        return
    sensor = controller.ammeters[current.sensor]
    log = world.device.steps(name)
    times_s, flowed_a = world.told(current.sensor)
    volts = current_v(sensor, flowed_a)
    codes = np.minimum(np.floor(CODES * volts / reference_v(sensor, controller.board)), CODES - 1)
    age_s = loop.next_step_s(sensor.oversample * TICK_S) + world.step_s
    before_s = np.insert(log["time_s"], 0, -math.inf)[:-1]
    since_s = np.where(log["steps"] == 1, before_s, log["time_s"] - age_s)
    spans = _spans(times_s, since_s, log["time_s"] + world.step_s)
    least, most = _extremes(codes, spans)
    code = log["current.raw"] / sensor.oversample
    is_true = (least - 1 <= code) & (code <= most + 1)
    for row in np.flatnonzero(~is_true)[:1]:
        flowed = flowed_a[slice(*spans[row])]
        yield (
            f"{name} measured {log['current.amperes'][row]:.2f} A at "
            f"{log['time_s'][row]:.2f} s, where {flowed.min():.2f} to "
            f"{flowed.max():.2f} A flowed"
        )
