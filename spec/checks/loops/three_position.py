"""Three-position control: the cooler, and the dead band between heating and cooling."""

from heatwright.spec.algorithms import ThreePosition
from heatwright.spec.checks.finding import Finding, Findings, loop_sensors
from heatwright.spec.controller import Controller
from heatwright.spec.problems import Path
from heatwright.spec.quantity import about, number, rounded_up
from heatwright.spec.simulation import ThermalNetwork

_PLANT: Path = ("simulation", "plant")


def coolers_have_a_use(controller: Controller) -> Findings:
    """Find three-position algorithms without a cooler, and coolers that are never switched on."""
    for name, loop in controller.loops.items():
        cools = loop.algorithm.cools
        if cools and loop.cooler is None:
            yield Finding(
                ("loops", name, "algorithm", "kind"),
                "three_position needs a cooler, and the loop has none",
                "Add cooler: with a digital output to the loop, or use on_off",
                (("loops", name, "cooler"),),
            )
        elif not cools and loop.cooler is not None:
            yield Finding(
                ("loops", name, "cooler"),
                f"{loop.algorithm.kind} never cools",
                "Delete it, or use three_position",
                (("loops", name, "algorithm"),),
            )


def coolers_can_be_switched(controller: Controller) -> Findings:
    """Check that a cooler is an on-off output that only this loop uses."""
    taken: dict[str, str] = {}
    for name, loop in controller.loops.items():
        for key, part in (("heater", loop.heater), ("fan", loop.fan)):
            if part is not None:
                taken.setdefault(part, f"the {key} of the loop {name}")
    for name, loop in controller.loops.items():
        if loop.cooler is None:
            continue
        path: Path = ("loops", name, "cooler")
        cooler = controller.outputs.get(loop.cooler)
        user = taken.setdefault(loop.cooler, f"the cooler of the loop {name}")
        if user != f"the cooler of the loop {name}":
            yield Finding(
                path,
                f"{loop.cooler} already is {user}",
                "Give the cooler an output of its own",
                (("loops",),),
            )
        elif cooler is not None and not cooler.is_on_off:
            yield Finding(
                path,
                f"{loop.cooler} is of the kind {cooler.kind}, and a cooler is only on or off",
                "Name a digital output",
                (("outputs", loop.cooler),),
            )
        elif cooler and cooler.always_runs:
            yield Finding(
                ("outputs", loop.cooler, "runs"),
                f"the cooler of the loop {name} would always be on",
                "Delete runs",
                (path,),
            )


def coolers_cool(controller: Controller, plant: ThermalNetwork) -> Findings:
    """Find coolers that change nothing in the plant."""
    for name, loop in controller.loops.items():
        cooler = loop.cooler
        if cooler in controller.outputs and cooler not in plant.fans:
            yield Finding(
                (*_PLANT, "fans") if plant.fans else _PLANT,
                f"fans needs an entry for {cooler}, the cooler of the loop {name}",
                f"Write {cooler}: {{link: […, ambient], factor: …}} under fans",
                (("loops", name), ("outputs", str(cooler)), _PLANT),
            )


def dead_band_has_room(controller: Controller) -> Findings:
    """Check the hysteresis against the dead band, and their difference against the sensor's step.

    Between the end of heating and the start of cooling there must be a reading with neither on.
    """
    for name, loop, sensor in loop_sensors(controller):
        algorithm = loop.algorithm
        if not isinstance(algorithm, ThreePosition):
            continue
        path: Path = ("loops", name, "algorithm")
        step_k = sensor.step_at_k(loop.setpoint.maximum_c, controller.board.mcu)
        between_k = 2 * algorithm.dead_band_k - algorithm.hysteresis_k
        if algorithm.hysteresis_k > algorithm.dead_band_k:
            yield Finding(
                (*path, "hysteresis"),
                f"{number(algorithm.hysteresis_k)} K is more than the dead band of "
                f"{number(algorithm.dead_band_k)} K, so heating would continue above the setpoint",
                f"Use at most {number(algorithm.dead_band_k)} K",
                ((*path, "dead_band"),),
            )
        elif between_k <= step_k:
            needed_k = (step_k + algorithm.hysteresis_k) / 2
            yield Finding(
                (*path, "dead_band"),
                f"heating ends {about(between_k)} K below where cooling begins, and a step of the "
                f"sensor is {about(step_k)} K at the highest setpoint, so one step may lead from "
                "one to the other",
                f"Use more than {rounded_up(needed_k)} K",
                ((*path, "hysteresis"), ("sensors", loop.sensor), ("loops", name, "setpoint")),
            )
