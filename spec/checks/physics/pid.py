"""Pid on the simulated machine: its gains and limits suffice, and do not overheat."""

from heatwright.spec.algorithms import Pid
from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.physics.machine import Machine
from heatwright.spec.physics.heated_loop import BORNE_HALVINGS, most_borne
from heatwright.spec.quantity import about, celsius, duration, number, rounded_up


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


def _is_held(machine: Machine, algorithm: Pid, target_k: float, below_k: float) -> bool:
    """Return whether the duty at `below_k` below a setpoint holds the machine there, or nearer."""
    percent = algorithm.kp * below_k if below_k > algorithm.dead_band_k else 0.0
    if algorithm.band_k is not None and below_k >= algorithm.band_k:
        percent = algorithm.output.maximum_percent
    percent = max(percent, algorithm.output.minimum_percent)
    output = machine.output
    percent *= percent / 100 * output.cycle_s >= output.shortest_pulse_s
    power_w = min(machine.power_w * percent / 100, machine.full_power_w)
    return machine.plant.steady_k(power_w) >= target_k - below_k


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
