"""The heater's power against the ramps of the stored programs."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.physics.machine import Machine
from heatwright.spec.physics.heated_loop import BORNE_HALVINGS, most_borne
from heatwright.spec.physics.matrices import apply
from heatwright.spec.problems import Path
from heatwright.spec.programs import HoldBack, Programs
from heatwright.spec.quantity import about, celsius, duration, number
from heatwright.spec.units import PROGRAM_RATE

STEPS_AHEAD = 16
"""Simulated steps of a ramp during the time that the sensor needs to respond to the heater."""

MOST_STEPS = 20_000
"""Maximum number of simulated steps of one ramp; only absurd ramps would need more."""

HOUR_S = 3600.0


class Ramp(NamedTuple):
    """A rising ramp of a program; its temperatures are above ambient."""

    path: Path
    key: str
    from_k: float
    to_k: float
    seconds: float

    @property
    def rate_k_per_s(self) -> float:
        """Slope of the setpoint, K/s."""
        return (self.to_k - self.from_k) / self.seconds

    def setpoint_k(self, time_s: float) -> float:
        """Setpoint above ambient at a time after the ramp's start, K."""
        return self.from_k + self.rate_k_per_s * min(time_s, self.seconds)


def ramps_can_be_followed(machine: Machine, programs: Programs) -> Findings:
    """Find ramps on which even an ideal control would lag so far that the program's clock waits.

    If full power is enough for the whole machine to rise at that rate, the ramp is good. If not, it
    is simulated from the steady state, the best case, in which the least heat must still be stored.
    """
    if not machine.reaches or machine.full_power_w == 0:
        return
    within_k = (programs.hold_back or HoldBack.model_validate({})).within_k
    for ramp in _ramps(machine, programs):
        if ramp.to_k > machine.target_k:
            continue  # targets_can_be_chosen reports it
        needed_w = machine.plant.ramp_power_w(ramp.to_k, ramp.rate_k_per_s)
        if needed_w <= machine.full_power_w:
            continue
        lost_s = _lost_after_s(machine, ramp, within_k)
        if lost_s is not None:
            at_c = machine.ambient_c + ramp.setpoint_k(lost_s)
            yield Finding(
                (*ramp.path, ramp.key),
                f"{number(machine.full_power_w)} W are too little for this ramp: from a steady "
                f"state the plant lags by more than {number(within_k)} K after "
                f"{duration(round(lost_s))}, at "
                f"{about(at_c)} °C; at {celsius(machine.ambient_c + ramp.to_k)} this rate needs "
                f"{about(needed_w)} W",
                _slower(machine, ramp),
                (*machine.because_of, ("programs",)),
            )


def _ramps(machine: Machine, programs: Programs) -> Iterator[Ramp]:
    """List the rising ramps of all programs; a program starts at the machine's temperature."""
    for index, program in enumerate(programs.stored):
        from_k = machine.start_k
        for place, segment in enumerate(program.segments):
            if segment.to_c is None:
                continue
            path: Path = ("programs", "stored", index, "segments", place)
            to_k = segment.to_c - machine.ambient_c
            if to_k > from_k and segment.over_s is not None:
                yield Ramp(path, "over", from_k, to_k, segment.over_s)
            elif to_k > from_k and segment.at_k_per_h is not None:
                yield Ramp(path, "at", from_k, to_k, (to_k - from_k) * HOUR_S / segment.at_k_per_h)
            from_k = to_k


class _Follower:
    """An ideal control: each step has the power that reaches the setpoint of a later time."""

    def __init__(self, machine: Machine, start_k: float, step_s: float, ahead_s: float) -> None:
        self._machine, self._step_s, self._ahead_s = machine, step_s, ahead_s
        self._state = machine.plant.rest(start_k)
        self._linearize()

    def _linearize(self) -> None:
        """Compute the matrices of a step at the present state, where radiation is linearized."""
        self._about = self._state
        self._step, self._step_added = self._machine.plant.pushed(self._step_s, self._state)
        self._ahead, self._ahead_added = self._machine.plant.pushed(self._ahead_s, self._state)

    def advance(self, aim_k: float) -> float:
        """Advance by a step with the power for a temperature; return the temperature reached."""
        plant, full_w = self._machine.plant, self._machine.full_power_w
        if plant.bent(self._about, self._state):
            self._linearize()
        none_k = plant.sensed_k(apply(self._ahead, self._state))
        per_watt_k = plant.sensed_k(self._ahead_added)
        power_w = full_w
        if per_watt_k > 0:  # only absurd machines do not respond within that time
            power_w = min(max((aim_k - none_k) / per_watt_k, 0.0), full_w)
        self._state = [
            value + power_w * added
            for value, added in zip(apply(self._step, self._state), self._step_added, strict=True)
        ]
        return plant.sensed_k(self._state)


def _lost_after_s(machine: Machine, ramp: Ramp, within_k: float) -> float | None:
    """Follow a ramp from a steady state; return when the lag is first too large, None if never."""
    ahead_s = machine.plant.answer_s()
    step_s = max(ahead_s / STEPS_AHEAD, ramp.seconds / MOST_STEPS)
    follower = _Follower(machine, ramp.from_k, step_s, ahead_s)
    time_s = 0.0
    while time_s < ramp.seconds:
        sensed_k = follower.advance(ramp.setpoint_k(time_s + ahead_s))
        time_s += step_s
        if ramp.setpoint_k(time_s) - sensed_k > within_k:
            return time_s
    return None


def _slower(machine: Machine, ramp: Ramp) -> str:
    """Return the remedy: how slow the ramp must be so that full power is enough at its end."""
    plant, full_w = machine.plant, machine.full_power_w
    least = most_borne(
        lambda rate: plant.ramp_power_w(ramp.to_k, rate) <= full_w,
        0.0,
        ramp.rate_k_per_s,
        BORNE_HALVINGS,
    )
    if least == 0:
        return "Use more power, or a lower temperature"
    if ramp.key == "at":
        slow = math.floor(least * HOUR_S * 10) / 10
        return f"Use at most {number(slow)} {PROGRAM_RATE.base}, or more power"
    minutes = math.ceil((ramp.to_k - ramp.from_k) / least / 60)
    return f"Use at least {minutes} min, or more power"
