"""Figures of merit of a run, from the readings of the control steps.

They describe the response to the last change of the setpoint (or to power-up, if it never changed),
up to the first disturbance of the machine. For a switched loop the response begins when it is
switched on, if that was later, and ends when it is switched off. Disturbances are in
`Metrics.disturbances`. The *step* of the response is the setpoint minus the reading at its start.

If a program ran, its whole run counts (heatwright.sim.judges.firing): the overshoot is that of the
holds, the steady part is that of the last hold, and there is no rise or settling time.
"""

from dataclasses import dataclass

import numpy as np

from heatwright.sim.judges.disturbances import Disturbance, disturbances, undisturbed
from heatwright.sim.judges.firing import Firing, firing_of
from heatwright.sim.plants import powers_of
from heatwright.sim.trace import Series, StepLog, Trace
from heatwright.spec import RULES, Controller, TimeProportionalOutput

STEADY_SHARE = 1 / 3
"""The steady part is the last third of the response."""

SETTLED_SHARE = 0.02
"""Settled is within 2 % of the step (Åström & Hägglund, Advanced PID Control, 2006, chapter 4)."""

AUDIBLE_HZ = (20.0, 20_000.0)
"""The range of human hearing."""


@dataclass(frozen=True)
class Metrics:
    """Figures of merit of one loop in one run."""

    setpoint_c: float
    """The last setpoint."""
    maximum_c: float
    """Highest reading of the response."""
    overshoot_k: float
    """How far the readings went beyond the setpoint, in the direction of the step; not below 0."""
    rise_time_s: float | None
    """From the first reading beyond 10 % of the step to the first beyond 90 %; None if never."""
    settling_s: float | None
    """From the start of the response until the readings stay within 2 % of the step around the
    setpoint, but at least within one step of the sensor; None if they never do."""
    steady_minimum_c: float
    """Lowest reading of the steady part."""
    steady_maximum_c: float
    """Highest reading of the steady part."""
    steady_error_k: float
    """Largest distance of a reading from the setpoint in the steady part."""
    iae_ks: float
    """Integral of the absolute error over the response, K·s."""
    switchings: float
    """How often the heater was switched on in the whole run."""
    audible: bool
    """Whether the heater is switched at a frequency that can be heard."""
    energy_j: float
    """Heat from the heater in the whole run."""
    disturbances: tuple[Disturbance, ...]
    """The disturbances after the last change of the setpoint, and the loop's reactions."""
    tracking_k: float | None = None
    """Largest distance from the setpoint on a program's ramps; None if no ramp was judged."""


def metrics(trace: Trace, controller: Controller, loop: str | None = None) -> Metrics:
    """Evaluate a loop of a run.

    trace -- the run; controller -- its specification; loop -- name of the loop; the first if None.
    Raises ValueError: the run is too short: no control step had a reading.
    """
    name = loop or next(iter(controller.loops))
    spec = controller.loops[name]
    log = trace.steps[name]
    if firing := firing_of(log, spec):
        return _fired(trace, controller, name, firing)
    response = response_of(log)
    response = response[response["has_reading"] != 0]
    if not len(response):
        statuses = log["reading_status"]
        said = f"; its last step says {RULES[int(statuses[-1])].id}" if len(statuses) else ""
        raise ValueError(f"Loop {name} had no reading of sensor {spec.sensor} in this run{said}")
    disturbed = disturbances(trace, response)
    response = undisturbed(trace, response)
    times_s = response["time_s"] - response["time_s"][0]
    readings_c = response["temperature_c"].astype(float)
    setpoint_c = float(response["setpoint_c"][-1])
    errors_k = readings_c - setpoint_c
    resolution_k = controller.thermometers[spec.sensor].step_at_k(setpoint_c, controller.board.mcu)
    steady_c = readings_c[times_s >= times_s[-1] * (1 - STEADY_SHARE)]
    return Metrics(
        setpoint_c=setpoint_c,
        maximum_c=float(readings_c.max()),
        overshoot_k=overshoot(readings_c, setpoint_c),
        rise_time_s=rise_time(times_s, readings_c, setpoint_c),
        settling_s=settling(times_s, readings_c, setpoint_c, resolution_k),
        steady_minimum_c=float(steady_c.min()),
        steady_maximum_c=float(steady_c.max()),
        steady_error_k=float(np.abs(steady_c - setpoint_c).max()),
        iae_ks=float(spec.integral(np.abs(errors_k).sum())),
        switchings=switchings(log, controller, name),
        audible=audible(log, controller, name),
        energy_j=energy(trace, controller, spec.heater),
        disturbances=disturbed,
    )


def _fired(trace: Trace, controller: Controller, name: str, firing: Firing) -> Metrics:
    """Evaluate a run in which there were programs."""
    spec, log = controller.loops[name], trace.steps[name]
    readings_c = firing.rows["temperature_c"].astype(float)
    steady_c = firing.steady["temperature_c"].astype(float)
    setpoint_c = float(firing.steady["setpoint_c"][-1])
    return Metrics(
        setpoint_c=setpoint_c,
        maximum_c=float(readings_c.max()),
        overshoot_k=firing.overshoot_k,
        rise_time_s=None,
        settling_s=None,
        steady_minimum_c=float(steady_c.min()),
        steady_maximum_c=float(steady_c.max()),
        steady_error_k=float(np.abs(steady_c - firing.steady["setpoint_c"]).max()),
        iae_ks=float(spec.integral(np.abs(readings_c - firing.rows["setpoint_c"]).sum())),
        switchings=switchings(log, controller, name),
        audible=audible(log, controller, name),
        energy_j=energy(trace, controller, spec.heater),
        disturbances=disturbances(trace, firing.rows),
        tracking_k=firing.tracking_k,
    )


def response_start(log: StepLog) -> int:
    """Return the row of the last change of the setpoint, 0 if it never changed."""
    changes = np.flatnonzero(np.diff(log["setpoint_c"]))
    return int(changes[-1]) + 1 if len(changes) else 0


def response_of(log: StepLog) -> StepLog:
    """Return the steps of the last response; of a switched loop, those while it was on, if any."""
    if "enabled" in (log.dtype.names or ()) and log["enabled"].any():
        on = np.flatnonzero(log["enabled"])
        log = log[: int(on[-1]) + 1]
        off = np.flatnonzero(log["enabled"] == 0)
        log = log[int(off[-1]) + 1 if len(off) else 0 :]
    return log[response_start(log) :]


def overshoot(readings_c: Series, setpoint_c: float) -> float:
    """Return how far readings went beyond the setpoint, in the direction of the step, K."""
    upwards = setpoint_c >= readings_c[0]
    beyond_k = readings_c.max() - setpoint_c if upwards else setpoint_c - readings_c.min()
    return max(0.0, float(beyond_k))


def rise_time(times_s: Series, readings_c: Series, setpoint_c: float) -> float | None:
    """Return the time from the first reading beyond 10 % of the step to the first beyond 90 %."""
    step_k = setpoint_c - readings_c[0]
    if step_k == 0:
        return None
    progress = (readings_c - readings_c[0]) / step_k
    begun, done = progress >= 0.1, progress >= 0.9
    if not done.any():
        return None
    return float(times_s[done.argmax()] - times_s[begun.argmax()])


def settling(
    times_s: Series, readings_c: Series, setpoint_c: float, resolution_k: float
) -> float | None:
    """Return when the readings enter the band around the setpoint and stay, None if never."""
    band_k = max(SETTLED_SHARE * abs(setpoint_c - readings_c[0]), resolution_k)
    outside = np.flatnonzero(np.abs(readings_c - setpoint_c) > band_k)
    if not len(outside):
        return 0.0
    entry = int(outside[-1]) + 1
    return float(times_s[entry]) if entry < len(times_s) else None


def switchings(log: StepLog, controller: Controller, loop: str) -> float:
    """Count how often the heater was switched on.

    At a partial duty that is once per pulse; otherwise once per change from off to full.
    """
    spec = controller.loops[loop]
    pulses_hz = pulse_rates(log, controller, spec.heater)
    on = log["duty_percent"] > 0
    partial = on & (log["duty_percent"] < 100) & (pulses_hz > 0)
    full = on & ~partial
    begun = np.count_nonzero(full & ~np.concatenate(([False], on[:-1])))
    return float(begun + spec.integral(pulses_hz[partial].sum()))


def audible(log: StepLog, controller: Controller, loop: str) -> bool:
    """Return whether the heater was switched at a frequency that can be heard."""
    lowest_hz, highest_hz = AUDIBLE_HZ
    pulses_hz = pulse_rates(log, controller, controller.loops[loop].heater)
    partial = (log["duty_percent"] > 0) & (log["duty_percent"] < 100)
    return bool((partial & (lowest_hz <= pulses_hz) & (pulses_hz <= highest_hz)).any())


def pulse_rates(log: StepLog, controller: Controller, output: str) -> Series:
    """Return the output's switching rate in 1/s at the duty of each step.

    0 for an output without partial duty. If the duty is spread over a window, the number of pulses
    is that of the steps that are on, or that are off, whichever is less.
    """
    spec = controller.outputs[output]
    if spec.frequency_hz:
        return np.full(len(log), spec.frequency_hz)
    if not isinstance(spec, TimeProportionalOutput):
        return np.zeros(len(log))
    if spec.distribution == "burst":
        return np.full(len(log), 1 / spec.window_s)
    whole = round(spec.window_s / spec.resolution_s)
    on_steps = log["output.on_steps"].astype(np.int64)
    rates: Series = np.minimum(on_steps, whole - on_steps) / spec.window_s
    return rates


def energy(trace: Trace, controller: Controller, output: str) -> float:
    """Return the heat that an output gave in the whole run, J."""
    power_w = powers_of(controller)[output]
    steps_s = np.diff(trace.times_s, prepend=trace.times_s[0])
    return float((trace.on_fraction[output] * steps_s).sum() * power_w)
