"""The second sensor of a loop: a monitor that can agree with the first."""

import math

from heatwright.spec.checks.finding import Finding, Findings, loop_sensors, shows_its_range
from heatwright.spec.checks.loops.timing import restart_s
from heatwright.spec.checks.references import unknown
from heatwright.spec.controller import Controller
from heatwright.spec.problems import Path
from heatwright.spec.quantity import about, celsius, duration, rounded_up
from heatwright.spec.sensors import Thermometer


def second_sensors_are_monitors(controller: Controller) -> Findings:
    """Check that `also` names a monitor of one loop only, and that `agreement` is given, too."""
    users: dict[str, str] = {}
    for name, loop in controller.loops.items():
        path: Path = ("loops", name, "also")
        rule: Path = ("loops", name, "protection", "agreement")
        if loop.also is None:
            if loop.protection.agreement is not None:
                yield Finding(
                    rule,
                    "the loop has no second sensor to compare with",
                    "Delete it, or add also: with the name of a monitor to the loop",
                )
            continue
        if controller.monitors:
            yield from unknown(path, loop.also, "monitors", controller.monitors)
        else:
            yield Finding(
                path,
                f"{loop.also} must be a monitor, and there are no monitors",
                f"Add monitors: {{{loop.also}: {{sensor: …, warning: …, limit: …}}}}",
                (("monitors",),),
            )
        if loop.protection.agreement is None:
            yield Finding(
                path,
                "the largest allowed difference of the two sensors is missing",
                "Add agreement: {within: 5 K} to the loop's protection",
                (rule,),
            )
        user = users.setdefault(loop.also, name)
        if user != name:
            yield Finding(
                path,
                f"{loop.also} already is the second sensor of the loop {user}",
                "Name a monitor of its own",
                (("loops", user, "also"),),
            )


def second_sensors_can_agree(controller: Controller) -> Findings:
    """Check `agreement` against both sensors' errors, and the second one's limit and range."""
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
                f"two healthy sensors may read {about(most_k)} K apart at the highest setpoint",
                f"Use more than {rounded_up(most_k)} K",
                because_of,
            )
        least_c = loop.protection.maximum_c + most_k
        if monitor.limit_c < least_c:
            yield Finding(
                ("monitors", str(loop.also), "limit"),
                f"{celsius(monitor.limit_c)} may be reached before the loop's own maximum, as the "
                f"two sensors may read {about(most_k)} K apart",
                f"Use at least {celsius(math.ceil(10 * least_c) / 10)}",
                (("loops", name, "protection", "maximum"), *because_of),
            )
        starts_s = restart_s(second.first_s, loop)
        if second.first_s and loop.protection.stale_after_s < starts_s:
            yield Finding(
                ("loops", name, "protection", "stale_after"),
                f"after a brief loss of its supply {monitor.sensor} reads again only later; "
                "until then the loop has no reading",
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
    """Return the largest difference of two healthy sensors at the same temperature, K."""
    mcu = controller.board.mcu
    return sum(each.step_at_k(at_c, mcu) + each.error_k(at_c) for each in (first, second))
