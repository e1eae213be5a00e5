"""How a loop reacts to disturbances of its machine: fed filament, a fan that starts."""

from dataclasses import dataclass

import numpy as np

from heatwright.sim.trace import StepLog, Trace

RECOVERED_K = 0.5
"""Half a degree around the setpoint, as users of hotends demand (Klipper's and Marlin's windows
for `ready` are wider)."""


@dataclass(frozen=True)
class Disturbance:
    """One disturbance, from its time to that of the next."""

    at_s: float
    what: str
    dip_k: float
    """Largest distance of a reading below the setpoint; at least 0."""
    rise_k: float
    """Largest distance of a reading above the setpoint; at least 0."""
    recovered_after_s: float | None
    """Time until the readings stay within the band; 0 if they never leave it, None if they do not
    come back."""


def disturbances(
    trace: Trace, response: StepLog, within_k: float = RECOVERED_K
) -> tuple[Disturbance, ...]:
    """Evaluate the disturbances of a response.

    trace -- the run; response -- control steps with a reading since the last change of the
    setpoint; within_k -- half the width of the band that counts as recovered, K.
    """
    start_s = float(response["time_s"][0])
    events = [event for event in trace.events if event.disturbs and event.time_s >= start_s]
    ends_s = [*(event.time_s for event in events[1:]), np.inf]
    found = []
    for event, end_s in zip(events, ends_s, strict=False):
        part = response[(response["time_s"] >= event.time_s) & (response["time_s"] < end_s)]
        if len(part):
            found.append(_evaluated(event.time_s, event.text, part, within_k))
    return tuple(found)


def undisturbed(trace: Trace, response: StepLog) -> StepLog:
    """Return the steps of a response until the first disturbance of the machine."""
    start_s = float(response["time_s"][0])
    times_s = [event.time_s for event in trace.events if event.disturbs and event.time_s > start_s]
    return response[response["time_s"] < min(times_s)] if times_s else response


def _evaluated(at_s: float, what: str, part: StepLog, within_k: float) -> Disturbance:
    errors_k = part["temperature_c"].astype(float) - float(part["setpoint_c"][-1])
    outside = np.flatnonzero(np.abs(errors_k) > within_k)
    recovered_after_s: float | None = 0.0
    if len(outside):
        entry = int(outside[-1]) + 1
        recovered_after_s = float(part["time_s"][entry]) - at_s if entry < len(part) else None
    return Disturbance(
        at_s,
        what,
        max(0.0, -float(errors_k.min())),
        max(0.0, float(errors_k.max())),
        recovered_after_s,
    )
