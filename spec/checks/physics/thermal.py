"""Physics of whole machines: enough power, and protections that a healthy machine does not trip.

The plant is heated from cold at full power until the sensor shows the highest setpoint: the worst
case of a healthy machine for the rules that watch its heating. Then the heater goes off, and the
heat that it has already stored still reaches the sensor.
"""

from heatwright.spec.checks.finding import Finding, Findings, loop_heaters, loop_sensors
from heatwright.spec.checks.physics import pid
from heatwright.spec.checks.physics.coasting import (
    coasting_settles,
    cooling_is_slow_enough,
    dead_band_holds,
    falling_comes_back,
    falling_stays_above_below,
    overshoot_stays_below_maximum,
)
from heatwright.spec.checks.physics.jumps import doses_do_not_run_away, readings_do_not_jump
from heatwright.spec.checks.physics.machine import Machine
from heatwright.spec.checks.physics.peaks import lying_sensors_are_borne, nodes_bear_the_maximum
from heatwright.spec.checks.physics.power import autotune_has_time, heater_suffices
from heatwright.spec.checks.physics.warm import frozen_rule_holds, heating_rule_holds_warm
from heatwright.spec.checks.programs.firing import ramps_can_be_followed
from heatwright.spec.commands import commanded
from heatwright.spec.controller import Controller
from heatwright.spec.outputs import Switch
from heatwright.spec.physics.feeds import fed, lasting_feed_mm_per_s
from heatwright.spec.physics.heated_loop import heated_loop
from heatwright.spec.quantity import about, celsius, duration, number, rounded_up
from heatwright.spec.simulation import Simulation

BRIEF_S = 60.0
"""Shorter feeds may need more heat than the heater gives, if no rule `heating` sets a time."""


def thermal(controller: Controller, *, any_setpoint: bool = True) -> Findings:
    """Run all checks of a machine's physics on every loop that the plant heats.

    any_setpoint -- whether somebody may choose another setpoint than the initial one.
    """
    plant = controller.simulation
    if plant is None:
        return
    readable = {name for name, _, _ in loop_sensors(controller)}
    for name, _, heater in loop_heaters(controller):
        if heater.power_w is None or name not in readable:
            continue
        machine = Machine(controller, name, heater, plant)
        found = [*_heating_holds(controller, machine, plant)]
        yield from found or _fed_holds(controller, name, heater, plant)
        for check in (
            pid.least_duty_cools,
            autotune_has_time,
            rise_rate_holds,
            overshoot_stays_below_maximum,
            coasting_settles,
            cooling_is_slow_enough,
            falling_comes_back,
            falling_stays_above_below,
            dead_band_holds,
            pid.window_is_smoothed,
            readings_do_not_jump,
            doses_do_not_run_away,
            pid.rest_is_not_below,
            pid.restart_stays_above_below,
        ):
            yield from check(machine)
        if machine.course:
            heated = heated_loop(controller, name, plant)
            broken = [*frozen_rule_holds(machine, heated)]
            broken += nodes_bear_the_maximum(machine, heated)
            yield from broken
            if any_setpoint and not found and not broken:
                yield from lying_sensors_are_borne(controller, machine, heated)
        if any_setpoint:
            yield from _heats_at_all(controller, machine, plant.ambient_c)
            yield from pid.integral_suffices(machine)
            yield from pid.integral_cools(machine)
            if controller.programs is not None and controller.programs.loop == name:
                yield from ramps_can_be_followed(machine, controller.programs)


def _heating_holds(controller: Controller, machine: Machine, plant: Simulation) -> Findings:
    """Check that the heater's power suffices, and that the rules about heating do not trip."""
    yield from heater_suffices(machine)
    if machine.course:
        heated = heated_loop(controller, str(machine.path[1]), plant)
        warm = heating_rule_holds_warm(machine, heated)
        yield from [*heating_rule_holds(machine)] or warm


def _heats_at_all(controller: Controller, machine: Machine, ambient_c: float) -> Findings:
    """Find loops that never heat: ambient is at the setpoint, and no interface can change it."""
    initial_c = machine.loop.setpoint.initial_c
    if machine.loop.cooler is not None or commanded(controller, str(machine.path[1])):
        return
    if initial_c <= ambient_c:
        yield Finding(
            (*machine.path, "setpoint", "initial"),
            f"{celsius(initial_c)} is not above the ambient temperature of {celsius(ambient_c)}, "
            "and no interface can set another setpoint, so the loop never heats",
            "Write a higher setpoint or a lower ambient temperature, or add an interface that "
            "serves the loop",
            (("interfaces",), ("simulation", "ambient")),
        )


def _fed_holds(
    controller: Controller, name: str, heater: Switch, simulation: Simulation
) -> Findings:
    """Check the power and rule `heating` while the scenario feeds filament, which takes heat away.

    Feeds shorter than the time of `heating`, or a minute, may take more heat than the heater gives.
    `frozen` is not widened for a feed: with a stuck reading the duty of the feed would overheat the
    machine once feeding ends.
    """
    heating = controller.loops[name].protection.heating
    mm_per_s = lasting_feed_mm_per_s(simulation, heating.within_s if heating else BRIEF_S)
    if mm_per_s == 0:
        return
    cooled = fed(controller, simulation, mm_per_s)
    for finding in _heating_holds(controller, Machine(controller, name, heater, cooled), cooled):
        yield finding._replace(
            reason=f"{finding.reason}, with {number(mm_per_s)} mm/s of filament",
            remedy=f"{finding.remedy}, or feed less",
        )


def heating_rule_holds(machine: Machine) -> Findings:
    """Find a rule `heating_failed` that trips on a healthy machine.

    As in the firmware, each rise restarts the time. A reading may be too low by up to one step of
    the sensor, so a rise may need one step more. The first rise also waits for the dead time, and
    until the heater may be switched on.
    """
    rule = machine.loop.protection.heating
    if rule is None or not machine.course:
        return
    since_s, from_k = -machine.plant.delay_s - machine.held_off_s, machine.course[0][1]
    longest_s = 0.0
    for time_s, sensed_k in machine.course:
        longest_s = max(longest_s, time_s - since_s)
        if sensed_k >= from_k + rule.rise_k + machine.step_k(sensed_k):
            since_s, from_k = time_s, sensed_k
    if longest_s > rule.within_s:
        yield machine.finding(
            ("protection", "heating", "within"),
            f"at full power this healthy plant needs {duration(round(longest_s))} for one of its "
            f"rises of {number(rule.rise_k)} K on the way to "
            f"{celsius(machine.loop.setpoint.maximum_c)}",
            f"Use more than {duration(round(longest_s))}, or a smaller rise",
        )


def rise_rate_holds(machine: Machine) -> Findings:
    """Find a rule `rise_rate` that trips on a healthy machine at full power."""
    limit = machine.loop.protection.rise_rate_k_per_s
    needed, steepest, step_k = max(
        (
            (machine.seen(rate) + machine.loop.rate_k_per_s(step_k), rate, step_k)
            for rate, step_k in machine.rates()
        ),
        default=(0.0, 0.0, 0.0),
    )
    if needed > limit:
        yield machine.finding(
            ("protection", "rise_rate"),
            f"at full power this healthy plant heats at {machine.told(steepest)}, and one step of "
            f"the sensor, {about(step_k)} K, may add "
            f"{about(machine.loop.rate_k_per_s(step_k))} K/s between two readings",
            f"Use at least {rounded_up(needed)} K/s",
        )
