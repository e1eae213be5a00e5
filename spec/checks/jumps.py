"""What makes a healthy reading jump, beside the heat that is asked for: noise, and pulses of it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import islice, pairwise

from heatwright.spec.algorithms import OnOff, Pid, ThreePosition
from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.limits import PEAK
from heatwright.spec.checks.machine import MOST_POINTS, Machine
from heatwright.spec.outputs import TimeProportionalOutput
from heatwright.spec.quantity import about, rounded_up


def readings_do_not_jump(machine: Machine) -> Findings:
    """Find a rule `rise_rate` that noise breaks in health, or a window's pulse at full power."""
    period_s = machine.loop.period_s
    noise_k = PEAK * math.sqrt(2) * machine.noise_k
    pulse_k = _pulse_k(machine)
    if not machine.course or not noise_k + pulse_k:
        return
    # Where a step ends and what noise adds have nothing to do with each other.
    jump_k = math.hypot(machine.step_k(machine.target_k), noise_k) + pulse_k
    needed = _steepest(machine.course) + jump_k / period_s
    if needed > machine.loop.protection.rise_rate_k_per_s:
        yield Finding(
            (*machine.path, "protection", "rise_rate"),
            f"beside its rise the reading of this plant, healthy, may jump by {about(jump_k)} K in "
            f"a period, with {about(noise_k)} K of noise and {about(pulse_k)} K of a pulse in the "
            "heater's window",
            f"Use at least {rounded_up(needed)} K/s",
            machine.because_of,
        )


def doses_do_not_run_away(machine: Machine) -> Findings:
    """Find a rule `runaway.above` narrower than what one step of the reading asks for.

    A reading that falls by one step is a steep slope for as long as a period. What an algorithm
    gives for it comes while the temperature may be at the setpoint, or above.
    """
    rule, jump_k = machine.loop.protection.runaway, machine.step_k(machine.target_k)
    jump_k = math.hypot(jump_k, PEAK * math.sqrt(2) * machine.noise_k)
    dose_k = _dose_k(machine, jump_k)
    if rule is not None and rule.above_k is not None and dose_k and dose_k + jump_k >= rule.above_k:
        yield Finding(
            (*machine.path, "protection", "runaway", "above"),
            f"for a fall of the reading by {about(jump_k)} K in a period the algorithm asks for "
            f"heat that warms the plant, healthy, by {about(dose_k)} K",
            f"Use more than {rounded_up(dose_k + jump_k)} K",
            machine.because_of,
        )


def _dose_k(machine: Machine, jump_k: float) -> float:
    """Rise of the reading after the heat for a fall of the reading by a jump in one period, K."""
    algorithm, output, period_s = machine.loop.algorithm, machine.output, machine.loop.period_s
    if isinstance(algorithm, Pid):
        slope = jump_k / (algorithm.derivative_filter_s + period_s)
        share = min(algorithm.kd * slope, algorithm.output.maximum_percent) / 100
    elif isinstance(algorithm, OnOff | ThreePosition):
        share = float(algorithm.lead_s > 0)
    if not share:
        return 0.0
    on_s, power_w = period_s + machine.held_on_s, share * machine.full_power_w
    if isinstance(output, TimeProportionalOutput):
        on_s, power_w = min(share * output.window_s, period_s), machine.power_w
    warm = machine.plant.advance(machine.plant.start(0.0), power_w, on_s)
    quick_s = machine.plant.fastest_s() / 4
    cooling = machine.plant.course(warm, 0.0, quick_s, 64 * quick_s)
    highest_k = machine.plant.sensed_k(warm)
    for _, state in islice(cooling, MOST_POINTS):
        if machine.plant.sensed_k(state) < highest_k:
            break
        highest_k = machine.plant.sensed_k(state)
    return highest_k


def _pulse_k(machine: Machine) -> float:
    """Rise in a period, beyond that of the mean power, while a pulse in the window lasts, K."""
    output, algorithm = machine.output, machine.loop.algorithm
    if not isinstance(output, TimeProportionalOutput) or not isinstance(algorithm, Pid):
        return 0.0
    beyond_w = machine.power_w - machine.full_power_w
    if beyond_w <= 0:
        return 0.0
    share = algorithm.output.maximum_percent / 100
    on_s = output.resolution_s if output.distribution == "spread" else share * output.window_s
    quick_s = min(machine.plant.fastest_s(), on_s) / 4
    course = machine.plant.course(machine.plant.start(0.0), beyond_w, quick_s, 64 * quick_s)
    points = []
    for time_s, state in islice(course, MOST_POINTS):
        points.append((time_s, machine.plant.sensed_k(state)))
        if time_s >= on_s:
            break
    return _steepest(points) * min(on_s, machine.loop.period_s)


def _steepest(course: Iterable[tuple[float, float]]) -> float:
    """Return the quickest rise of a course, K/s."""
    return max(
        (
            (after_k - before_k) / (after_s - before_s)
            for (before_s, before_k), (after_s, after_k) in pairwise(course)
        ),
        default=0.0,
    )
