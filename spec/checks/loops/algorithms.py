"""Algorithms: outputs that can make the duty, rules that they do not trip, a use of autotune."""

from heatwright.spec.checks.finding import Finding, Findings, loop_heaters, loop_sensors
from heatwright.spec.checks.interfaces.gcode import host_loops
from heatwright.spec.commands import modbus_of
from heatwright.spec.controller import Controller
from heatwright.spec.quantity import about, number, rounded_up


def duty_can_be_made(controller: Controller) -> Findings:
    """Find an algorithm with a duty between 0 % and 100 % on an output that is only on or off."""
    for name, loop, heater in loop_heaters(controller):
        if loop.algorithm.continuous and heater.is_on_off:
            yield Finding(
                ("loops", name, "algorithm", "kind"),
                f"{loop.algorithm.kind} needs a duty between 0 % and 100 %, and {loop.heater} of "
                f"the kind {heater.kind} is only on or off",
                "Make the output pwm or time_proportional, or use on_off",
                (("outputs", loop.heater),),
            )


def rest_is_not_frozen(controller: Controller) -> Findings:
    """Find loops that may settle below the setpoint, where the rule `sensor_frozen` would trip.

    Without an integral the temperature settles where the proportional term supplies the losses:
    below the setpoint, with the heater on and a constant reading. With `holding` the rule accepts
    such a reading.
    """
    for name, loop in controller.loops.items():
        rule = loop.protection.frozen
        if loop.settles_below and rule is not None and rule.holding_percent == 0:
            yield Finding(
                ("loops", name, "algorithm", "ki"),
                "without an integral the temperature may settle below the setpoint, and "
                "the rule sensor_frozen would trip",
                "Give ki a value above 0, or write frozen: {holding: …} or frozen: off in "
                "protection",
                (("loops", name, "protection", "frozen"),),
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
    """Find an autotune that nobody could start, or whose algorithm has no gains."""
    for name, loop in controller.loops.items():
        if loop.autotune is None:
            continue
        path = ("loops", name, "autotune")
        if not loop.algorithm.tunable:
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
