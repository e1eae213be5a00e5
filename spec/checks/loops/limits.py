"""Temperatures: setpoints in order, protections beyond them, sensors that can read all of them."""

import math
from itertools import product

from heatwright.spec.checks.finding import Finding, Findings, loop_sensors, loop_types
from heatwright.spec.checks.references import interface_loops
from heatwright.spec.checks.sensing.max31856 import is_lowered, or_lower
from heatwright.spec.commands import zero_is_off
from heatwright.spec.controller import Controller
from heatwright.spec.problems import Path
from heatwright.spec.quantity import about, celsius, number, rounded_up

PEAK = 6.0
"""Multiple of its standard deviation that noise exceeds once in a machine's lifetime."""


def setpoints_in_order(controller: Controller) -> Findings:
    """Check that minimum ≤ initial ≤ maximum."""
    for name, loop in controller.loops.items():
        path = ("loops", name, "setpoint")
        setpoint = loop.setpoint
        if setpoint.minimum_c > setpoint.maximum_c:
            yield Finding(
                (*path, "minimum"),
                f"the lowest setpoint of {celsius(setpoint.minimum_c)} is above the highest of "
                f"{celsius(setpoint.maximum_c)}",
                "Exchange minimum and maximum",
                ((*path, "maximum"),),
            )
        elif setpoint.initial_c == 0 and zero_is_off(controller, name):
            continue
        elif not setpoint.minimum_c <= setpoint.initial_c <= setpoint.maximum_c:
            yield Finding(
                (*path, "initial"),
                f"{celsius(setpoint.initial_c)} is outside the range of setpoints",
                f"Use {celsius(setpoint.minimum_c)} to {celsius(setpoint.maximum_c)}",
                ((*path, "minimum"), (*path, "maximum"), ("interfaces",)),
            )


def maximum_above_setpoints(controller: Controller) -> Findings:
    """Check that `over_temperature` does not trip on a healthy machine.

    At the highest setpoint a healthy loop may read too high by the sensor's error. An on-off loop
    also rises above it by its hysteresis before it switches off, and a loop with a dead band may
    settle above the setpoint by that band.
    """
    for name, loop, sensor, _ in loop_types(controller):
        highest_c = loop.setpoint.maximum_c
        swing_k = loop.algorithm.rests_within_k
        least_c = highest_c + swing_k + sensor.error_k(highest_c)
        if loop.protection.maximum_c <= least_c:
            yield Finding(
                ("loops", name, "protection", "maximum"),
                f"{celsius(loop.protection.maximum_c)} is too near to the highest setpoint of "
                f"{celsius(highest_c)}: the sensor may be wrong by "
                f"{about(sensor.error_k(highest_c))} K"
                + (f" and the loop swings by {number(swing_k)} K" if swing_k else ""),
                f"Use more than {celsius(math.ceil(least_c * 10) / 10)}; 10 to 15 K above the "
                "setpoint is usual",
                (("loops", name, "setpoint"), ("loops", name, "algorithm"), ("sensors",)),
            )


def runaway_outside_the_band(controller: Controller) -> Findings:
    """Keep `runaway_above` and `runaway_below` outside the band in which a healthy loop swings."""
    for name, loop in controller.loops.items():
        band_k, rule = loop.algorithm.rests_within_k, loop.protection.runaway
        if rule is None or not band_k:
            continue
        for key, limit_k in (("above", rule.above_k), ("below", rule.below_k)):
            if limit_k is not None and limit_k <= band_k:
                yield Finding(
                    ("loops", name, "protection", "runaway", key),
                    f"{number(limit_k)} K is not outside the band of ±{number(band_k)} K in which "
                    "a healthy loop stays",
                    f"Use more than {number(band_k)} K",
                    (("loops", name, "algorithm"),),
                )


def minimum_below_setpoints(controller: Controller) -> Findings:
    """Keep `under_temperature` below the lowest setpoint.

    A lowest setpoint of 0 °C that means off is not held, and needs no check.
    """
    if any(True for _ in interface_loops(controller)):
        return  # an interface names an undefined loop: the loop it commands is not known
    for name, loop in controller.loops.items():
        protection = loop.protection
        if loop.setpoint.minimum_c == 0 and zero_is_off(controller, name):
            continue
        if protection.minimum_c >= loop.setpoint.minimum_c:
            yield Finding(
                ("loops", name, "protection", "minimum"),
                f"{celsius(protection.minimum_c)} is not below the lowest setpoint of "
                f"{celsius(loop.setpoint.minimum_c)}",
                f"Use less than {celsius(loop.setpoint.minimum_c)}",
                (("loops", name, "setpoint", "minimum"), ("interfaces",)),
            )


def start_is_allowed(controller: Controller) -> Findings:
    """Find simulated machines that break a protection at the start, or later in the steady state.

    A reading may deviate by a step of the sensor, and by its noise.
    """
    simulation = controller.simulation
    if simulation is None:
        return
    at_c: dict[Path, float] = {("simulation", "ambient"): simulation.ambient_c}
    if simulation.plant.initial_c is not None:
        at_c["simulation", "plant", "initial"] = simulation.plant.initial_c
    for (name, loop, sensor), (path, start_c) in product(loop_sensors(controller), at_c.items()):
        protection, sense = loop.protection, simulation.plant.sense.get(loop.sensor)
        noise_k = PEAK * (sense.noise_k if sense is not None else 0.0)
        off_k = sensor.step_at_k(start_c, controller.board.mcu) + noise_k
        lowest_c, highest_c = protection.minimum_c + off_k, protection.maximum_c - off_k
        if not lowest_c < start_c < highest_c:
            yield Finding(
                path,
                f"at {celsius(start_c)} a protection of the loop {name} trips",
                f"Use more than {about(lowest_c)} °C and less than {about(highest_c)} °C",
                (("loops", name, "protection"), ("simulation",)),
            )


def protections_in_range(controller: Controller) -> Findings:
    """Find limits that no reading may reach, because the sensor's range ends before them."""
    for name, loop, sensor, kind in loop_types(controller):
        lowest_c, highest_c = sensor.range_c
        path = ("loops", name, "protection")
        with_type = f"with type {kind} " if kind else ""
        or_less = f", or remove {kind} from selectable" if kind else ""
        has_range = "range_c" in type(sensor).model_fields
        or_wider = f", or give sensor {loop.sensor} a wider range" if has_range else ""
        reaches_c = highest_c - sensor.error_k(highest_c)
        if loop.protection.maximum_c > reaches_c and not is_lowered(controller, loop, kind):
            implied = "" if "maximum_c" in loop.protection.model_fields_set else " (the default)"
            yield Finding(
                (*path, "maximum"),
                f"{celsius(loop.protection.maximum_c)}{implied} may never be read: the "
                f"range of {loop.sensor} {with_type}ends at {celsius(highest_c)}, where a reading "
                f"may be {about(sensor.error_k(highest_c))} K too low",
                f"Use at most {celsius(math.floor(reaches_c * 10) / 10)}{or_wider}{or_less}"
                f"{or_lower(loop, kind)}",
                (("sensors", loop.sensor), ("loops", name, "setpoint", "maximum")),
            )
        reaches_c = lowest_c + sensor.error_k(lowest_c)
        if loop.protection.minimum_c < reaches_c:
            yield Finding(
                (*path, "minimum"),
                f"{celsius(loop.protection.minimum_c)} may never be read: the range of "
                f"{loop.sensor} {with_type}ends at {celsius(lowest_c)}, where a reading may be "
                f"{about(sensor.error_k(lowest_c))} K too high",
                f"Use at least {celsius(math.ceil(reaches_c * 10) / 10)}{or_wider}{or_less}",
                (("sensors", loop.sensor),),
            )


def efforts_are_known(controller: Controller) -> Findings:
    """Find effort rules where the plant does not give the power that a reading needs."""
    for name, loop in controller.loops.items():
        effort = loop.protection.effort
        if effort is not None and not effort.has_band:
            plant = controller.simulation is not None
            yield Finding(
                ("loops", name, "protection", "effort"),
                "on this plant a healthy machine would trip the rule, however long its time is"
                if plant
                else "without a model of the plant the power that holds a temperature is not known",
                "Write effort: off" if plant else "Add the section `simulation`, or delete effort",
                (("simulation",), ("loops", name), ("outputs", loop.heater)),
            )


def rise_rate_above_steps(controller: Controller) -> Findings:
    """Find rise rates that one step of the sensor exceeds between two readings.

    The larger of the sensor's steps at the two ends of a healthy loop's readings is used.
    """
    for name, loop, sensor in loop_sensors(controller):
        limit_k = loop.rise_per_period_k
        lowest_c = max(loop.setpoint.minimum_c, loop.protection.minimum_c)
        step_k = max(
            sensor.step_at_k(end_c, controller.board.mcu)
            for end_c in (lowest_c, loop.setpoint.maximum_c)
        )
        if limit_k < step_k:
            yield Finding(
                ("loops", name, "protection", "rise_rate"),
                f"{number(loop.protection.rise_rate_k_per_s)} K/s is {number(limit_k)} K in a "
                f"period, less than a step of the sensor's reading, {about(step_k)} K, so any "
                "change of the reading would be a fault",
                f"Use at least {rounded_up(loop.rate_k_per_s(step_k))} K/s",
                (("sensors", loop.sensor), ("loops", name, "period")),
            )
