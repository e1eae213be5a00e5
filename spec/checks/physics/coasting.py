"""Checks of a machine after its heater is off: it rises further (coasts), and then it cools."""

import math
from collections.abc import Iterable
from itertools import pairwise

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.physics.machine import Machine
from heatwright.spec.quantity import about, celsius, duration, number, rounded_up

FASTER = 2.0
"""A machine is faster by this factor if its capacities and resistances are 30 % smaller."""


def overshoot_stays_below_maximum(machine: Machine) -> Findings:
    """Find a maximum that plain on-off control reaches by coasting from the highest setpoint."""
    algorithm = machine.loop.algorithm
    if not machine.course or algorithm.continuous or algorithm.lead_s > 0:
        return
    coasts_to_k = max(sensed_k for _, sensed_k in machine.coasting())
    peak_c = machine.ambient_c + coasts_to_k + algorithm.off_at_k
    if peak_c >= machine.loop.protection.maximum_c:
        yield machine.finding(
            ("protection", "maximum"),
            f"with a setpoint of {celsius(machine.loop.setpoint.maximum_c)} this plant coasts up "
            f"to {rounded_up(peak_c)} °C after the heater is off",
            f"Use more than {rounded_up(peak_c)} °C, or add a lead to the algorithm",
        )


def coasting_settles(machine: Machine) -> Findings:
    """Find a rule `rising_while_off` that trips on heat which was stored before switching off."""
    rule = machine.loop.protection.rising_while_off
    if rule is None or not machine.course:
        return
    late_s = machine.plant.delay_s + machine.held_on_s
    settled_k = peak_k = peak_s = 0.0
    for time_s, sensed_k in machine.coasting():
        if time_s + late_s <= rule.settle_s:
            settled_k = sensed_k
        if sensed_k > peak_k:
            peak_s, peak_k = time_s + late_s, sensed_k
    if peak_s > rule.settle_s and peak_k - settled_k >= rule.rise_k:
        yield machine.finding(
            ("protection", "rising_while_off", "settle"),
            f"with the heater off this plant continues to rise for {duration(round(peak_s))}: by "
            f"{about(peak_k - settled_k)} K after settle is over",
            f"Use at least {duration(round(peak_s))}, or a greater rise",
        )


def falling_stays_above_below(machine: Machine) -> Findings:
    """Find a rule `runaway_below` that on-off control trips, because the heat arrives late.

    A machine may fall twice as fast as its plant: capacities and resistances 30 % smaller.
    """
    algorithm, rule = machine.loop.algorithm, machine.loop.protection.runaway
    if rule is None or rule.below_k is None or not machine.course or algorithm.continuous:
        return
    below_k = algorithm.on_at_k
    course = list(machine.falling(machine.target_k - below_k, algorithm.lead_s))
    limit_k = machine.target_k - (below_k + (rule.below_k - below_k) / FASTER)
    beyond_s = _below_s(course, limit_k)
    if beyond_s >= rule.for_s:
        fall_k = machine.target_k - min(sensed_k for _, sensed_k in course)
        needed_k = below_k + FASTER * (fall_k - below_k)
        yield machine.finding(
            ("protection", "runaway", "below"),
            f"until the heater's heat reaches the sensor, the reading falls to {about(fall_k)} K "
            f"below the setpoint of {celsius(machine.loop.setpoint.maximum_c)}, and to "
            f"{about(needed_k)} K below it in a plant that is {number(FASTER)} times as fast",
            f"Use more than {rounded_up(needed_k)} K or a longer `for`, or let the heater switch "
            "on sooner",
        )


def falling_comes_back(machine: Machine) -> Findings:
    """Find a rule `runaway_below` that trips if a setpoint is raised while the machine cools.

    If the reading is just above the new setpoint − `below`, the rule is active at once, and the
    machine cools further until the heater may switch on and its heat reaches the sensor.
    """
    rule = machine.loop.protection.runaway
    if rule is None or rule.below_k is None or not machine.course:
        return
    edge_k = machine.target_k - rule.below_k
    beyond_s = _below_s(machine.falling(edge_k, 0.0), edge_k)
    if edge_k > 0 and beyond_s >= rule.for_s:
        yield machine.finding(
            ("protection", "runaway", "for"),
            f"if a setpoint of {celsius(machine.loop.setpoint.maximum_c)} is commanded while this "
            f"plant cools through {celsius(machine.ambient_c + edge_k)}, the reading is more than "
            f"{number(rule.below_k)} K below it for {duration(math.ceil(beyond_s))}, until the "
            "heater's heat arrives",
            f"Use more than {duration(math.ceil(beyond_s))}, or let the heater switch on sooner",
        )


def _below_s(course: Iterable[tuple[float, float]], limit_k: float) -> float:
    """Return for how long a course is at a limit or below, s."""
    return sum(
        later_s - time_s
        for (time_s, sensed_k), (later_s, _) in pairwise(course)
        if sensed_k <= limit_k
    )


def cooling_is_slow_enough(machine: Machine) -> Findings:
    """Find a `rise_rate`, which also limits falling, that a healthy machine's cooler exceeds."""
    loop = machine.loop
    if loop.cooler is None or not machine.course:
        return
    fastest = max(
        (before_k - after_k) / (after_s - before_s)
        for (before_s, before_k), (after_s, after_k) in pairwise(machine.cooling())
    )
    step_k = machine.step_k(machine.target_k)
    needed = machine.seen(fastest) + loop.rate_k_per_s(step_k)
    if needed > loop.protection.rise_rate_k_per_s:
        yield Finding(
            (*machine.path, "protection", "rise_rate"),
            f"the rule counts a fall like a rise: while {loop.cooler} is on, this plant cools by "
            f"{machine.told(fastest)} at {celsius(loop.setpoint.maximum_c)}, and one step of the "
            f"reading, {about(step_k)} K in a period, looks like "
            f"{machine.told(loop.rate_k_per_s(step_k))} more",
            f"Use at least {rounded_up(needed)} K/s",
            (*machine.because_of, ("outputs", loop.cooler)),
        )


def dead_band_holds(machine: Machine) -> Findings:
    """Find shortest times on in which the temperature goes through the whole dead band.

    Heater and cooler would then alternate without end, with any lead.
    """
    algorithm, loop = machine.loop.algorithm, machine.loop
    if not algorithm.cools or not machine.course or loop.cooler is None:
        return
    band_k = algorithm.swing_k
    for output, what, change_k, held_s in (
        (loop.heater, "rises", machine.rise_k(machine.held_on_s), machine.held_on_s),
        (loop.cooler, "falls", machine.fall_k(machine.cooler_held_on_s), machine.cooler_held_on_s),
    ):
        if change_k >= band_k:
            yield Finding(
                ("outputs", output, "minimum_on"),
                f"in {duration(held_s)} this plant {what} by up to {about(change_k)} K, through "
                f"the whole band of ±{number(algorithm.rests_within_k)} K",
                "Use a shorter time, or a wider dead_band",
                (*machine.because_of, ("outputs", output)),
            )
