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
