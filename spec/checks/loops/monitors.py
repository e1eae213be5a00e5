"""Monitors: sensors of their own, and limits that they can read but a healthy machine never has."""

import math
from collections.abc import Iterator

from heatwright.spec.checks.finding import Finding, Findings, shows_its_range
from heatwright.spec.checks.loops.limits import PEAK
from heatwright.spec.checks.loops.timing import MOST_MISSING, periods_s, restart_s
from heatwright.spec.checks.references import unknown
from heatwright.spec.controller import Controller
from heatwright.spec.loops import Loop
from heatwright.spec.monitors import Monitor, watching_loop
from heatwright.spec.outputs import always_running
from heatwright.spec.physics.heated_loop import SPARE, SUMMER_C, heated_loop
from heatwright.spec.physics.neighbours import Neighbour, warmed_k
from heatwright.spec.problems import Path
from heatwright.spec.quantity import about, celsius, duration, number
from heatwright.spec.sensors import Thermometer, shortest_period_s
from heatwright.spec.simulation import Simulation, ThermalNetwork

SPREAD = 0.3
"""Thermal resistances have a tolerance of ±30 %: full power may heat by this share more."""


def monitor_sensors(controller: Controller) -> Findings:
    """Find monitors whose sensor is undefined, measures no temperature, or is already in use."""
    users = {loop.sensor: f"the loop {name}" for name, loop in controller.loops.items()}
    for name, monitor in controller.monitors.items():
        path: Path = ("monitors", name, "sensor")
        because_of: tuple[Path, ...] = (("sensors", monitor.sensor), ("loops",))
        yield from unknown(path, monitor.sensor, "sensors", controller.sensors)
        sensor = controller.thermometers.get(monitor.sensor)
        user = users.setdefault(monitor.sensor, f"the monitor {name}")
        if monitor.sensor in controller.ammeters:
            yield Finding(
                path,
                f"{monitor.sensor} measures a current, and a monitor needs a temperature",
                "Name a temperature sensor",
                because_of,
            )
        elif user != f"the monitor {name}":
            yield Finding(
                path,
                f"{user} already reads {monitor.sensor}, and its protections watch it",
                "Give the monitor a sensor of its own",
                because_of,
            )
        elif sensor is not None and sensor.moving_average > 1:
            yield Finding(
                ("sensors", monitor.sensor, "moving_average"),
                f"monitor {name} must judge each reading at once, and an average delays readings",
                "Delete it",
                (path,),
            )


def monitors_have_a_step(controller: Controller) -> Findings:
    """Find monitors whose sensor is too slow for the period of every loop."""
    for name, monitor in controller.monitors.items():
        sensor = controller.thermometers.get(monitor.sensor)
        if sensor is not None and watching_loop(controller, name) is None:
            yield Finding(
                ("monitors", name, "sensor"),
                f"{monitor.sensor} takes {duration(shortest_period_s(sensor))} for a reading, and "
                f"the longest period of a loop is {duration(controller.longest_period_s)}",
                "Give the sensor a lower resolution or oversample, or a loop a longer period",
                (("sensors", monitor.sensor), ("loops",)),
            )


def _watched(controller: Controller) -> Iterator[tuple[str, Monitor, Thermometer, Loop]]:
    """List the monitors with a sensor that shows its range, and the loop whose step reads it."""
    for name, monitor in controller.monitors.items():
        sensor, loop = controller.thermometers.get(monitor.sensor), watching_loop(controller, name)
        if loop is not None and sensor and shows_its_range(sensor, controller.board.mcu):
            yield name, monitor, sensor, controller.loops[loop]


def monitors_in_order(controller: Controller) -> Findings:
    """Check warning against limit, both against the sensor's range, and hysteresis against step."""
    for name, monitor, sensor, _ in _watched(controller):
        path: Path = ("monitors", name)
        (lowest_c, highest_c), because_of = sensor.range_c, (("sensors", monitor.sensor),)
        step_k = sensor.step_at_k(monitor.warning_c, controller.board.mcu)
        ends_c = monitor.warning_c - monitor.hysteresis_k
        reaches_c = highest_c - sensor.error_k(highest_c)
        highest_warning_c = monitor.limit_c - 2 * step_k
        if monitor.warning_c >= highest_warning_c:
            yield Finding(
                (*path, "warning"),
                f"{celsius(monitor.warning_c)} is not more than two steps of {monitor.sensor}, "
                f"{about(2 * step_k)} K, below the limit of {celsius(monitor.limit_c)}: the "
                "warning would come too late",
                f"Use less than {about(highest_warning_c)} °C",
                ((*path, "limit"), *because_of),
            )
        elif monitor.limit_c > reaches_c:
            yield Finding(
                (*path, "limit"),
                f"{celsius(monitor.limit_c)} may never be read: the range of "
                f"{monitor.sensor} ends at {celsius(highest_c)}, where a reading may be "
                f"{about(sensor.error_k(highest_c))} K too low",
                f"Use at most {celsius(math.floor(reaches_c * 10) / 10)}",
                because_of,
            )
        elif ends_c < lowest_c + sensor.error_k(lowest_c):
            yield Finding(
                (*path, "warning"),
                f"the warning ends at {celsius(ends_c)}, which may never be read: the "
                f"range of {monitor.sensor} ends at {celsius(lowest_c)}",
                "Use a higher warning, or less hysteresis",
                ((*path, "hysteresis"), *because_of),
            )
        elif monitor.hysteresis_k < step_k:
            yield Finding(
                (*path, "hysteresis"),
                f"{number(monitor.hysteresis_k)} K is less than a step of {monitor.sensor}, "
                f"{about(step_k)} K, so each step would start or end the warning",
                f"Use at least {about(step_k)} K",
                ((*path, "warning"), *because_of),
            )


def monitors_in_time(controller: Controller) -> Findings:
    """Check that `stale_after` lasts two periods and a sensor's start-up, and fits 8 bits."""
    for name, monitor, sensor, loop in _watched(controller):
        least_s, most_s = restart_s(sensor.first_s, loop), periods_s(MOST_MISSING, loop)
        if not least_s <= monitor.stale_after_s <= most_s:
            yield Finding(
                ("monitors", name, "stale_after"),
                f"{monitor.sensor} is read every {loop.told_period}: one lost reading is no "
                f"fault, and at most {MOST_MISSING} lost readings are counted",
                f"Use {duration(least_s)} to {duration(most_s)}",
                (("sensors", monitor.sensor), ("loops",)),
            )


def plant_covers_monitors(controller: Controller, plant: ThermalNetwork) -> Findings:
    """Find sensors of monitors that the plant's `sense` does not list."""
    for name, monitor in controller.monitors.items():
        if monitor.sensor in controller.sensors and monitor.sensor not in plant.sense:
            yield Finding(
                ("simulation", "plant", "sense"),
                f"the sensor '{monitor.sensor}' of the monitor '{name}' has no entry",
                f"Add {monitor.sensor}: {{node: …}}",
                (("monitors", name), ("sensors", monitor.sensor)),
            )


def monitors_hold(controller: Controller, simulation: Simulation) -> Findings:
    """Find limits that a healthy machine reaches in summer, so that the monitor's rule would trip.

    The sensor is hottest in the steady state with every loop at its highest setpoint, or on the
    way there at full power.
    """
    for name, monitor, sensor, _ in _watched(controller):
        try:
            hottest_c = _hottest_c(controller, simulation, monitor.sensor)
        except (ArithmeticError, AssertionError, LookupError, ValueError):
            continue  # the plant is wrong, and another check reports it
        noise_k = PEAK * simulation.plant.sense[monitor.sensor].noise_k
        needed_c = hottest_c + noise_k + sensor.error_k(hottest_c)
        if monitor.limit_c <= needed_c:
            yield Finding(
                ("monitors", name, "limit"),
                f"{celsius(monitor.limit_c)} would trip on a healthy machine: with every loop at "
                f"its highest setpoint, or on the way there, {monitor.sensor} may read "
                f"{about(needed_c)} °C in a room of "
                f"{about(max(SUMMER_C, simulation.ambient_c))} °C",
                f"Use more than {about(needed_c)} °C, or a cooler place for the sensor",
                (("sensors",), ("loops",), ("outputs",), ("simulation",)),
            )


def _hottest_c(controller: Controller, simulation: Simulation, sensor: str) -> float:
    ambient_c, plant = max(SUMMER_C, simulation.ambient_c), simulation.plant
    holding = [
        Neighbour(
            loop.heater,
            loop.sensor,
            loop.setpoint.maximum_c + loop.algorithm.rests_within_k - ambient_c,
        )
        for loop in controller.loops.values()
        if loop.setpoint.maximum_c > ambient_c
    ]
    running = always_running(controller.outputs)
    rest_k = warmed_k(plant, sensor, holding, ambient_c, running)
    node = str(plant.sense[sensor].node)
    way_k = sum(
        heated_loop(controller, name, simulation).way_k(node, ambient_c, SPREAD)
        for name in controller.loops
    )
    starts_c = simulation.ambient_c if plant.initial_c is None else plant.initial_c
    return max(ambient_c + (1 + SPARE) * rest_k, ambient_c + way_k, starts_c)
