"""Pid: limits and bands in order, gains that act."""

from heatwright.spec.algorithms import LEAST_RANGE_PERCENT, Pid
from heatwright.spec.checks.finding import Finding, Findings, loop_sensors
from heatwright.spec.commands import by_host
from heatwright.spec.controller import Controller
from heatwright.spec.quantity import about, number


def _pids(controller: Controller) -> list[tuple[str, Pid]]:
    return [(name, pid) for name, loop in controller.loops.items() if (pid := loop.algorithm.pid)]


def limits_in_order(controller: Controller) -> Findings:
    """Check that minimum < maximum, for the limits of the integral and of the output."""
    for name, algorithm in _pids(controller):
        for key in ("integral", "output"):
            limits = getattr(algorithm, key)
            if limits.minimum_percent >= limits.maximum_percent:
                yield Finding(
                    ("loops", name, "algorithm", key, "minimum"),
                    f"{number(limits.minimum_percent)} % is not below the maximum of "
                    f"{number(limits.maximum_percent)} %",
                    "Use a minimum below the maximum",
                    (("loops", name, "algorithm", key, "maximum"),),
                )


def integral_leaves_room(controller: Controller) -> Findings:
    """Find integrals whose minimum alone reaches the output's maximum."""
    for name, algorithm in _pids(controller):
        acts = algorithm.has_integral or algorithm.limits_adjustable
        least, most = algorithm.integral.minimum_percent, algorithm.output.maximum_percent
        if acts and most <= least < algorithm.integral.maximum_percent:
            yield Finding(
                ("loops", name, "algorithm", "integral", "minimum"),
                f"{number(least)} % is not below the output's maximum of {number(most)} %, so the "
                "integral alone would be full power",
                f"Use less than {number(most)} %",
                (("loops", name, "algorithm", "output"),),
            )


def adjustable_limits_have_a_use(controller: Controller) -> Findings:
    """Find adjustable limits that no host can set, that leave no range, or that hide a fault.

    With little integral a loop may never ask for full power, which `heating_failed` needs to see.
    """
    for name, algorithm in _pids(controller):
        if not algorithm.limits_adjustable:
            continue
        runaway = controller.loops[name].protection.runaway
        path = ("loops", name, "algorithm", "limits_adjustable")
        if not by_host(controller, name):
            yield Finding(
                path,
                "nobody could set the limits: no gcode interface serves this loop",
                "Delete it, or name the loop in a gcode interface",
                (("interfaces",),),
            )
        if runaway is None or runaway.below_k is None:
            yield Finding(
                path,
                "with little integral the loop may never ask for full power, so heating_failed "
                "could miss a dead heater, and no other rule detects it",
                "Write runaway: {below: …} in protection",
                (("loops", name, "protection", "runaway"),),
            )
        output = algorithm.output
        least = output.minimum_percent + LEAST_RANGE_PERCENT
        if output.minimum_percent < output.maximum_percent < least:
            yield Finding(
                ("loops", name, "algorithm", "output", "maximum"),
                f"{number(output.maximum_percent)} % leaves a host no range for its maximum, "
                f"which must be at least {number(least)} %, {number(LEAST_RANGE_PERCENT)} % above "
                "the minimum",
                f"Use at least {number(least)} %, or delete limits_adjustable",
                (path,),
            )


def something_acts(controller: Controller) -> Findings:
    """Find loops whose kp and ki are both 0."""
    for name, algorithm in _pids(controller):
        if algorithm.kp == 0 and algorithm.ki == 0:
            yield Finding(
                ("loops", name, "algorithm", "kp"),
                "with kp and ki both 0 nothing brings the temperature to the setpoint",
                "Give kp a value above 0",
            )


def bands_in_order(controller: Controller) -> Findings:
    """Check that the dead band is inside the band, and the band wider than a step of the sensor."""
    for name, loop, sensor in loop_sensors(controller):
        algorithm = loop.algorithm.pid
        if algorithm is None or algorithm.band_k is None:
            continue
        path = ("loops", name, "algorithm")
        step_k = sensor.step_at_k(loop.setpoint.maximum_c, controller.board.mcu)
        if algorithm.band_k <= algorithm.dead_band_k:
            yield Finding(
                (*path, "band"),
                f"{number(algorithm.band_k)} K is not above the dead band of "
                f"{number(algorithm.dead_band_k)} K, so there is no room between them",
                "Use a wider band, or a narrower dead band",
                ((*path, "dead_band"),),
            )
        elif algorithm.band_k <= step_k:
            yield Finding(
                (*path, "band"),
                f"{number(algorithm.band_k)} K is not above the sensor's step of "
                f"{about(step_k)} K at the highest setpoint, so the heater is only switched on and "
                "off",
                "Use a wider band; 10 K is usual",
                (("sensors", loop.sensor), ("loops", name, "setpoint", "maximum")),
            )
