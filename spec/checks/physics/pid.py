"""Pid on the simulated machine: its gains and limits suffice, and do not overheat."""

from collections.abc import Iterator
from itertools import islice

from heatwright.spec.algorithms import Pid
from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.physics.coasting import FASTER
from heatwright.spec.checks.physics.machine import MOST_POINTS, Machine
from heatwright.spec.physics.heated_loop import BORNE_HALVINGS, most_borne
from heatwright.spec.quantity import about, celsius, duration, number, rounded_up

STEPS_OF_A_RULE = 1000
"""Least number of steps in which a rule's time is simulated, if the loop's period allows it."""


def rest_is_not_below(machine: Machine) -> Findings:
    """Find a `runaway.below` that trips where a loop without an integral settles."""
    algorithm, rule = machine.loop.algorithm.pid, machine.loop.protection.runaway
    if algorithm is None or algorithm.ki or not algorithm.kp or not machine.reaches:
        return
    if rule is None or rule.below_k is None:
        return
    lowest_k = max(machine.loop.setpoint.minimum_c - machine.ambient_c, 0.0)
    targets_k = {machine.target_k, min(lowest_k, machine.target_k)}
    step_k = machine.step_k(machine.target_k)
    held_k = max(rule.below_k - step_k, 0.0)

    def falls(below_k: float) -> bool:
        return not all(_is_held(machine, algorithm, each_k, below_k) for each_k in targets_k)

    if not falls(held_k):
        return
    deepest_k = most_borne(falls, held_k, machine.target_k, BORNE_HALVINGS)
    yield machine.finding(
        ("protection", "runaway", "below"),
        f"without ki this loop settles up to {about(deepest_k)} K below its setpoint",
        f"Use more than {rounded_up(deepest_k + step_k)} K, or write ki",
    )


def restart_stays_above_below(machine: Machine) -> Findings:
    """Find a `runaway.below` that trips after a restart at a warm machine: the integral is lost.

    A machine may fall twice as fast as its plant: capacities and resistances 30 % smaller.
    """
    algorithm, rule = machine.loop.algorithm.pid, machine.loop.protection.runaway
    if algorithm is None or not algorithm.ki or not machine.reaches:
        return
    if rule is None or rule.below_k is None:
        return
    if _is_held(machine, algorithm, machine.target_k, rule.below_k):
        return
    step_s = max(machine.loop.periods_s(1), rule.for_s / STEPS_OF_A_RULE)
    below_s = longest_s = deepest_k = 0.0
    for short_k in islice(_restarted(machine, algorithm, step_s), MOST_POINTS):
        if short_k < deepest_k and short_k < rule.below_k:
            break
        deepest_k = max(deepest_k, short_k)
        below_s = below_s + step_s if short_k > rule.below_k else 0.0
        longest_s = max(longest_s, below_s)
    if longest_s >= rule.for_s:
        yield machine.finding(
            ("protection", "runaway", "below"),
            f"after a restart at {celsius(machine.loop.setpoint.maximum_c)} the integral is at "
            f"{number(_start(algorithm))} %, and until it has grown, the reading falls to "
            f"{about(deepest_k)} K below the setpoint in a plant that is {number(FASTER)} times "
            "as fast",
            f"Use more than {rounded_up(deepest_k)} K or a longer `for`, or larger gains",
        )


def _restarted(machine: Machine, algorithm: Pid, step_s: float) -> Iterator[float]:
    """Yield how far the reading is below the highest setpoint, K, in each step after a restart."""
    state, (least, most) = machine.plant.rest(machine.target_k), _limits(algorithm)
    integral = _start(algorithm)
    while True:
        short_k = machine.target_k - machine.plant.sensed_k(state)
        yield short_k
        if short_k > algorithm.dead_band_k:
            integral = min(max(integral + algorithm.ki * step_s * short_k, least), most)
        power_w = _given_w(machine, algorithm, short_k, integral)
        state = machine.plant.advance(state, power_w, FASTER * step_s)


def _is_held(machine: Machine, algorithm: Pid, target_k: float, below_k: float) -> bool:
    """Return whether the duty at `below_k` below a setpoint holds the machine there, or nearer.

    The integral has its value after a start.
    """
    power_w = _given_w(machine, algorithm, below_k, _start(algorithm))
    return machine.plant.steady_k(power_w) >= target_k - below_k


def _given_w(machine: Machine, algorithm: Pid, below_k: float, integral: float) -> float:
    """Return the power at `below_k` below a setpoint, W; integral -- in percent."""
    percent = integral + (algorithm.kp * below_k if below_k > algorithm.dead_band_k else 0.0)
    if algorithm.band_k is not None and below_k >= algorithm.band_k:
        percent = algorithm.output.maximum_percent
    percent = max(percent, algorithm.output.minimum_percent)
    output = machine.output
    percent *= percent / 100 * output.cycle_s >= output.shortest_pulse_s
    return min(machine.power_w * percent / 100, machine.full_power_w)


def _limits(algorithm: Pid) -> tuple[float, float]:
    return algorithm.integral.minimum_percent, algorithm.integral.maximum_percent


def _start(algorithm: Pid) -> float:
    """Return the integral after a start, in percent."""
    least, most = _limits(algorithm)
    return min(max(0.0, least), most) if algorithm.ki else 0.0


def window_is_smoothed(machine: Machine) -> Findings:
    """Find windows so long that the reading follows each switching of the heater.

    A swing as wide as the proportional band (100 %/kp) changes the duty from 0 % to 100 %: the loop
    would then react to its own window instead of to the machine.
    """
    algorithm, output = machine.loop.algorithm.pid, machine.output
    if algorithm is None or not algorithm.kp or not output.cycle_s:
        return
    windowed = output.is_windowed
    swing_k = machine.plant.swing_k(machine.pulse_w, output.cycle_s)
    band_k = 100.0 / algorithm.kp
    if swing_k >= band_k:
        yield Finding(
            ("outputs", machine.loop.heater, "window" if windowed else "frequency"),
            f"the temperature swings by {about(swing_k)} K in a "
            f"{'window' if windowed else 'cycle'} of {duration(output.cycle_s)}, more than the "
            f"proportional band of {about(band_k)} K",
            f"Use a {'shorter window' if windowed else 'higher frequency'}, or a smaller kp",
            machine.because_of,
        )


def integral_suffices(machine: Machine) -> Findings:
    """Check that the integral's maximum covers the losses at the highest setpoint by itself."""
    algorithm = machine.loop.algorithm.pid
    if algorithm is None or algorithm.ki == 0 or not machine.reaches:
        return
    most = algorithm.integral.maximum_percent
    ends_k = machine.plant.steady_k(machine.power_w * most / 100)
    if 0 < ends_k < machine.target_k:
        needed_w = machine.plant.power_w(machine.target_k)
        yield machine.finding(
            ("algorithm", "integral", "maximum"),
            f"{number(most)} % holds {about(machine.ambient_c + ends_k)} °C in this plant, not "
            f"the highest setpoint of {celsius(machine.loop.setpoint.maximum_c)}",
            f"Use at least {rounded_up(100 * needed_w / machine.power_w)} %",
        )


def integral_cools(machine: Machine) -> Findings:
    """Find a minimum of the integral that alone heats above the highest setpoint.

    If the reading were stuck just above the setpoint, the loop would overheat and no rule trip.
    """
    algorithm = machine.loop.algorithm.pid
    if algorithm is None or algorithm.ki == 0:
        return
    least = algorithm.integral.minimum_percent
    ends_c = machine.ambient_c + machine.plant.steady_k(machine.power_w * least / 100)
    highest_c = machine.loop.setpoint.maximum_c
    if least > 0 and ends_c > highest_c:
        yield machine.finding(
            ("algorithm", "integral", "minimum"),
            f"{number(least)} % alone heats to {about(ends_c)} °C in this plant, above the highest "
            f"setpoint of {celsius(highest_c)}",
            "Use a smaller minimum",
        )


def least_duty_cools(machine: Machine) -> Findings:
    """Find a minimum duty that alone heats above the lowest setpoint."""
    algorithm = machine.loop.algorithm.pid
    if algorithm is None or algorithm.output.minimum_percent == 0:
        return
    least_w = machine.power_w * algorithm.output.minimum_percent / 100
    ends_c = machine.ambient_c + machine.plant.steady_k(least_w)
    lowest_c = machine.loop.setpoint.minimum_c
    if ends_c > lowest_c:
        yield machine.finding(
            ("algorithm", "output", "minimum"),
            f"{number(algorithm.output.minimum_percent)} % alone heats to {about(ends_c)} °C, "
            f"above the lowest setpoint of {celsius(lowest_c)}",
            "Use a smaller minimum, or raise the lowest setpoint",
        )
