"""The heater's power: its voltage, and the losses; the maximum suffices, the minimum cools."""

import math

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.physics.machine import Machine
from heatwright.spec.controller import Controller
from heatwright.spec.quantity import about, celsius, duration, number, rounded_up


def supply_suffices(controller: Controller) -> Findings:
    """Check that the rated voltage is at most the supply's: PWM can only lower the voltage."""
    for name, output in controller.outputs.items():
        if output.rated_v is None:
            continue
        path = ("outputs", name, "rated")
        if output.supply_v is None:
            reason = "without a supply this key has no effect"
            yield Finding(path, reason, "Add supply: with its voltage")
        elif output.rated_v > output.supply_v:
            yield Finding(
                path,
                f"{number(output.rated_v)} V is more than the supply of "
                f"{number(output.supply_v)} V, so the load never has its rated power",
                "Write the power at the supply's voltage, and delete rated",
                (("outputs", name, "supply"),),
            )


def heater_suffices(machine: Machine) -> Findings:
    """Check that the heater's power covers the losses at the highest setpoint."""
    if machine.reaches or machine.full_power_w == 0:  # another check refuses a maximum of 0 %
        return
    highest_c = machine.ambient_c + machine.plant.steady_k(machine.full_power_w)
    if machine.is_limited:
        yield _limit_suffices(machine, highest_c)
        return
    share = machine.full_power_w / machine.power_w
    needed_w = machine.plant.power_w(machine.target_k) / share
    yield Finding(
        ("outputs", machine.loop.heater, "power"),
        f"{number(machine.full_power_w)} W heat this plant to {about(highest_c)} °C at most, and "
        f"never to the highest setpoint of {celsius(machine.loop.setpoint.maximum_c)}",
        f"Use at least {rounded_up(needed_w)} W, or a lower highest setpoint",
        machine.because_of,
    )


def _limit_suffices(machine: Machine, highest_c: float) -> Finding:
    """Report that the limit of the heater's current leaves too little power."""
    needed_share = machine.plant.power_w(machine.target_k) / machine.full_power_w
    needed_a = machine.limit_a * math.sqrt(needed_share)
    return Finding(
        ("outputs", machine.loop.heater, "current", "limit"),
        f"this current gives {about(machine.full_power_w)} W, which heat this plant to "
        f"{about(highest_c)} °C at most, and never to the highest setpoint of "
        f"{celsius(machine.loop.setpoint.maximum_c)}",
        f"Use at least {rounded_up(needed_a)} A, or a lower highest setpoint",
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


def autotune_has_time(machine: Machine) -> Findings:
    """Find autotune experiments whose time is over before the machine is warm."""
    autotune = machine.loop.autotune
    if autotune is None or not machine.course:
        return
    warm_s = machine.course[-1][0]
    if warm_s > autotune.timeout_s:
        yield machine.finding(
            ("autotune", "timeout"),
            f"at full power this plant needs {duration(round(warm_s))} only to reach the highest "
            "setpoint",
            f"Use several times {duration(round(warm_s))}",
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
