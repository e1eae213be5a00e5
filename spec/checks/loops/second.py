"""The second sensor of a loop: a monitor that can agree with the first."""

from __future__ import annotations

import math

from heatwright.spec.checks.finding import Finding, Findings, loop_sensors, shows_its_range
from heatwright.spec.checks.loops.timing import restart_s
from heatwright.spec.checks.references import unknown
from heatwright.spec.controller import Controller
from heatwright.spec.problems import Path
from heatwright.spec.quantity import about, celsius, duration, rounded_up
from heatwright.spec.sensors import Thermometer


def second_sensors_are_monitors(controller: Controller) -> Findings:
    """Find second sensors that are no monitors, or others' too, and what each needs."""
    users: dict[str, str] = {}
    for name, loop in controller.loops.items():
        path: Path = ("loops", name, "also")
        rule: Path = ("loops", name, "protection", "agreement")
        if loop.also is None:
            if loop.protection.agreement is not None:
                yield Finding(
                    rule,
                    "there is no second sensor that could agree",
                    "Delete it, or write also: and the name of a monitor at the loop",
                )
            continue
        if controller.monitors:
            yield from unknown(path, loop.also, "monitors", controller.monitors)
        else:
            yield Finding(
                path,
                f"there are no monitors, and {loop.also} has to be one",
                f"Add monitors: {{{loop.also}: {{sensor: …, warning: …, limit: …}}}}",
                (("monitors",),),
            )
        if loop.protection.agreement is None:
            yield Finding(
                path,
                "nothing says how far apart both sensors may be",
                "Add agreement: {within: 5 K} to the loop's protection",
                (rule,),
            )
        user = users.setdefault(loop.also, name)
        if user != name:
            yield Finding(
                path,
                f"{loop.also} is the second sensor of the loop {user}",
                "Name a monitor of its own",
                (("loops", user, "also"),),
            )


def second_sensors_can_agree(controller: Controller) -> Findings:
    """Check that the agreement exceeds both sensors' steps, and that the second one suits."""
    for name, loop, sensor in loop_sensors(controller):
        agreement, monitor = loop.protection.agreement, controller.monitors.get(loop.also or "")
        second = controller.thermometers.get(monitor.sensor) if monitor else None
        if monitor is None or second is None or agreement is None:
            continue
        if not shows_its_range(second, controller.board.mcu):
            continue
        because_of: tuple[Path, ...] = (("sensors", loop.sensor), ("sensors", monitor.sensor))
        most_k = _differ_k(controller, sensor, second, loop.setpoint.maximum_c)
        if agreement.within_k <= most_k:
            yield Finding(
                ("loops", name, "protection", "agreement", "within"),
                f"both sensors may be {about(most_k)} K apart at the highest setpoint, and be well",
                f"Use more than {rounded_up(most_k)} K",
                because_of,
            )
        least_c = loop.protection.maximum_c + most_k
        if monitor.limit_c < least_c:
            yield Finding(
                ("monitors", str(loop.also), "limit"),
                f"{celsius(monitor.limit_c)} comes before the loop's own maximum, for a sensor "
                f"that may be {about(most_k)} K apart",
                f"Use at least {celsius(math.ceil(10 * least_c) / 10)}",
                (("loops", name, "protection", "maximum"), *because_of),
            )
        starts_s = restart_s(second.first_s, loop)
        if second.first_s and loop.protection.stale_after_s < starts_s:
            yield Finding(
                ("loops", name, "protection", "stale_after"),
                f"it is over before {monitor.sensor}, without which the loop has no reading, reads "
                "again when its supply failed once",
                f"Use at least {duration(starts_s)}",
                (("loops", name, "also"), *because_of),
            )
        low_c, high_c = second.range_c
        if low_c > loop.protection.minimum_c or high_c < loop.protection.maximum_c:
            yield Finding(
                ("loops", name, "also"),
                f"the range of {monitor.sensor} does not reach from the protection's minimum to "
                "its maximum",
                "Name a sensor with a wider range",
                (("loops", name, "protection"), *because_of),
            )


def _differ_k(
    controller: Controller, first: Thermometer, second: Thermometer, at_c: float
) -> float:
    """Return how far apart two healthy sensors may read the same temperature, K."""
    mcu = controller.board.mcu
    return sum(each.step_at_k(at_c, mcu) + each.error_k(at_c) for each in (first, second))
