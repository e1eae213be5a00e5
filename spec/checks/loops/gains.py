"""Checks of the settings that belong to control: bands, `ready_within` and autotune."""

from heatwright.spec.checks.finding import Finding, Findings, loop_sensors
from heatwright.spec.checks.interfaces.host import host_loops
from heatwright.spec.commands import modbus_of
from heatwright.spec.controller import Controller
from heatwright.spec.quantity import about, number, rounded_up


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


def ready_can_last(controller: Controller) -> Findings:
    """Check that `ready_within` is above the sensor's step, the dead band and the hysteresis."""
    for name, loop, sensor in loop_sensors(controller):
        if loop.ready_within_k is None:
            continue
        algorithm = loop.algorithm
        rests = {
            "the sensor's step at the highest setpoint": sensor.step_at_k(
                loop.setpoint.maximum_c, controller.board.mcu
            ),
            "the dead band": getattr(algorithm, "dead_band_k", 0.0),
            "the hysteresis": getattr(algorithm, "hysteresis_k", 0.0),
        }
        what, widest_k = max(rests.items(), key=lambda item: item[1])
        if loop.ready_within_k <= widest_k:
            yield Finding(
                ("loops", name, "ready_within"),
                f"{number(loop.ready_within_k)} K is not above {what}, {about(widest_k)} K: the "
                "loop could settle and not be ready",
                f"Use more than {rounded_up(widest_k)} K",
                (("loops", name), ("sensors", loop.sensor)),
            )


def autotune_has_a_use(controller: Controller) -> Findings:
    """Find autotune that nobody could start, or of an algorithm that has no gains."""
    for name, loop in controller.loops.items():
        if loop.autotune is None:
            continue
        path = ("loops", name, "autotune")
        if loop.algorithm.pid is None:
            yield Finding(
                path,
                f"{loop.algorithm.kind} has no gains to find",
                "Delete it, or use pid",
                (("loops", name, "algorithm"),),
            )
        elif modbus_of(controller) is None and name not in host_loops(controller):
            yield Finding(
                path,
                "nobody could start autotune: no gcode or modbus_rtu interface serves this loop",
                "Delete it, or name the loop in a gcode interface",
                (("interfaces",),),
            )
