"""Noise and pulses of the heater make a healthy reading jump by more than its mean rise."""

import math
from collections.abc import Iterable, Iterator
from itertools import islice, pairwise

from heatwright.spec.board.timers import TICK_S
from heatwright.spec.checks.finding import Findings
from heatwright.spec.checks.loops.limits import PEAK
from heatwright.spec.checks.physics.machine import MOST_POINTS, Machine
from heatwright.spec.quantity import about, duration, rounded_up


def readings_do_not_jump(machine: Machine) -> Findings:
    """Find a `rise_rate` that noise, or a pulse at full power, trips on a healthy machine."""
    noise_k = PEAK * math.sqrt(2) * machine.noise_k
    pulse_k = _pulse_k(machine)
    if not machine.course or not noise_k + pulse_k:
        return
    # Quantization and noise are independent: their jumps add up as root of the sum of squares.
    jumps_k = [(rate, math.hypot(step_k, noise_k) + pulse_k) for rate, step_k in machine.rates()]
    if not jumps_k:
        return  # the plant never heats
    loop = machine.loop
    needed, jump_k = max((machine.seen(rate) + loop.rate_k_per_s(k), k) for rate, k in jumps_k)
    if needed > loop.protection.rise_rate_k_per_s:
        yield machine.finding(
            ("protection", "rise_rate"),
            f"a healthy reading of this plant may jump by {about(jump_k)} K in a period on top of "
            f"its mean rise, including {about(noise_k)} K of noise and {about(pulse_k)} K of one "
            "heater pulse",
            f"Use at least {rounded_up(needed)} K/s",
        )


def doses_do_not_run_away(machine: Machine) -> Findings:
    """Find a rule `runaway` that trips on the heat which follows one step of the reading.

    If a reading falls by one step, the control sees a steep slope for one period and adds heat,
    which may arrive while the temperature is at the setpoint or above.
    """
    rule, step_k = machine.loop.protection.runaway, machine.step_k(machine.target_k)
    if rule is None or rule.above_k is None:
        return
    highest_k, since_s = 0.0, math.inf
    for time_s, rise_k in islice(_dose(machine, step_k), MOST_POINTS):
        highest_k = max(highest_k, rise_k)
        if rise_k + step_k >= rule.above_k:
            since_s = min(since_s, time_s)
        elif since_s < math.inf or rise_k < highest_k:
            break
        if time_s - since_s >= rule.for_s:
            yield machine.finding(
                ("protection", "runaway", "above"),
                f"when a reading falls by one step, {about(step_k)} K, the algorithm gives heat "
                f"that warms this healthy plant by {about(highest_k)} K for longer than "
                f"{duration(rule.for_s)}",
                f"Use more than {rounded_up(highest_k + step_k)} K",
            )
            return


def _dose(machine: Machine, step_k: float) -> Iterator[tuple[float, float]]:
    """Yield times, s, and the rise that the heat for one falling step of the reading causes, K."""
    algorithm, output = machine.loop.algorithm, machine.output
    # The slope is computed from averaged readings, and decays with the derivative's filter.
    over_s = machine.loop.periods_s(machine.readings) + machine.held_on_s
    percent, on_s = algorithm.dose(step_k, over_s)
    if not percent:
        return
    share = percent / 100
    power_w = min(share * machine.power_w, machine.full_power_w)
    if output.cycle_s > on_s:
        on_s, power_w = min(share * output.full_share * output.cycle_s, on_s), machine.pulse_w
    plant, quick_s = machine.plant, machine.plant.fastest_s() / 4
    held_k = max(machine.loop.setpoint.minimum_c - machine.ambient_c, 0.0)
    # During this time the integral still adds its power.
    held_w = plant.power_w(held_k) if algorithm.has_integral else 0.0
    warmed = plant.advance(plant.rest(held_k), held_w + power_w, on_s)
    for time_s, state in plant.course(warmed, held_w, quick_s, 64 * quick_s):
        yield time_s, plant.sensed_k(state) - held_k


def _pulse_k(machine: Machine) -> float:
    """Rise between two readings during a pulse, beyond the rise at the mean power, K."""
    output, algorithm = machine.output, machine.loop.algorithm
    if not algorithm.continuous or output.cycle_s <= TICK_S:
        return 0.0
    beyond_w = machine.pulse_w - machine.full_power_w
    if beyond_w <= 0:
        return 0.0
    on_s = output.pulse_s(algorithm.full_percent / 100 * output.full_share)
    quick_s = min(machine.plant.fastest_s(), on_s) / 4
    course = machine.plant.course(machine.plant.start(0.0), beyond_w, quick_s, 64 * quick_s)
    points = []
    for time_s, state in islice(course, MOST_POINTS):
        points.append((time_s, machine.plant.sensed_k(state)))
        if time_s >= on_s:
            break
    return _steepest(points) * min(on_s, machine.seen(machine.loop.periods_s(1)))


def _steepest(course: Iterable[tuple[float, float]]) -> float:
    """Return the quickest rise of a course, K/s."""
    return max(
        (
            (after_k - before_k) / (after_s - before_s)
            for (before_s, before_k), (after_s, after_k) in pairwise(course)
        ),
        default=0.0,
    )
