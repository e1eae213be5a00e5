"""Measured currents: their outputs, limits and trips; resolution and timing of their sensors."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.references import current_sensors
from heatwright.spec.controller import Controller
from heatwright.spec.loops import Loop
from heatwright.spec.outputs import Switch, full_rms_a
from heatwright.spec.problems import Path
from heatwright.spec.quantity import about, duration, hertz, number, rounded_down, rounded_up
from heatwright.spec.sensing.circuits import reference_v
from heatwright.spec.sensing.conversion import CODES, LEAST_MARGIN_STEPS, TICK_S
from heatwright.spec.sensing.currents import FILTER_PULSES, Current, CurrentSensor

IDLE_SHARE = 0.05
"""Share of the nominal current below which a reading means no current."""
IDLE_STEPS = 3
"""Steps of the ADC below which a reading means no current."""


class Measured(NamedTuple):
    """An output whose current is measured, with its sensor."""

    name: str
    output: Switch
    current: Current
    sensor: CurrentSensor
    step_a: float
    """One step of the ADC as a root mean square at full duty, A, like limit and trip."""
    highest_a: float
    """Highest current that can be read, A, also as a root mean square at full duty."""

    @property
    def path(self) -> Path:
        """Path of the key `current` in the file."""
        return ("outputs", self.name, "current")

    @property
    def full_a(self) -> float | None:
        """Root mean square of the current at full duty, A; None if it is not known."""
        return full_rms_a(self.output)

    @property
    def idle_a(self) -> float:
        """Current below which a reading means no current, A."""
        return max(IDLE_SHARE * self.current.nominal_a, IDLE_STEPS * self.step_a)


def measured(controller: Controller) -> Iterator[Measured]:
    """List the outputs whose current is measured by a sensor that is defined."""
    for name, output in controller.switches.items():
        if output.current is None:
            continue
        sensor = controller.ammeters.get(output.current.sensor)
        if sensor is not None:
            full_scale_v = reference_v(sensor, controller.board.mcu)
            scale_v_per_a = sensor.scale_v_per_a * output.mean_of_rms
            step_a = full_scale_v / CODES / scale_v_per_a
            highest_a = (CODES - 0.5) * step_a - sensor.offset_v / scale_v_per_a
            yield Measured(name, output, output.current, sensor, step_a, highest_a)


FIRST_SHARE = 0.25
"""Duty, as a share, at which a heater with a current limit starts (docs/control.md, Current)."""


def current_sensors_measure_currents(controller: Controller) -> Findings:
    """Find outputs whose current sensor is a thermometer, and sensors that two outputs name."""
    first: dict[str, str] = {}
    for name, sensor_name in current_sensors(controller).items():
        path: Path = ("outputs", name, "current", "sensor")
        sensor = controller.sensors.get(sensor_name)
        if sensor is not None and not sensor.measures_current:
            yield Finding(
                path,
                f"{sensor_name} is of the kind {sensor.kind}, which measures a temperature",
                "Name a sensor of the kind current",
                (("sensors", sensor_name),),
            )
        elif first.setdefault(sensor_name, name) != name:
            yield Finding(
                path,
                f"{sensor_name} already measures the current of {first[sensor_name]}",
                "Give each output a sensor of its own",
            )


def currents_are_watched(controller: Controller) -> Findings:
    """Find measured currents of outputs that are no heater: only a loop's heater is watched."""
    heaters = {loop.heater for loop in controller.loops.values()}
    for name in current_sensors(controller):
        if name not in heaters:
            yield Finding(
                ("outputs", name, "current"),
                "nothing would watch this current: no loop has this output as its heater",
                "Delete it",
                (("loops",),),
            )


def currents_are_known(controller: Controller) -> Findings:
    """Find outputs without the values from which their healthy current follows."""
    for each in measured(controller):
        lacking = [
            key
            for key, value in (("power", each.output.power_w), ("supply", each.output.supply_v))
            if value is None
        ]
        if lacking:
            yield Finding(
                each.path,
                f"without {' and '.join(lacking)} the healthy current is not known",
                f"Add {' and '.join(f'{key}:' for key in lacking)} to the output",
                (("outputs", each.name),),
            )


def currents_are_held(controller: Controller) -> Findings:
    """Find limits that an on-off output cannot keep, and trips that a healthy heater reaches."""
    for each in measured(controller):
        limit_a, over_a = each.current.limit_a, each.current.over_a
        if limit_a is not None and each.output.is_on_off:
            yield Finding(
                (*each.path, "limit"),
                "an output that is only on or off cannot reduce its current",
                "Write trip instead, or make the output pwm",
                (("outputs", each.name),),
            )
            continue
        bounds_a = [bound for bound in (limit_a, each.full_a) if bound is not None]
        most_a = min(bounds_a, default=0.0)
        if limit_a is not None and over_a <= limit_a:
            yield Finding(
                (*each.path, "trip"),
                f"{number(over_a)} A is not above the limit of {number(limit_a)} A",
                f"Use more than {number(limit_a)} A, or delete trip",
                ((*each.path, "limit"),),
            )
        elif over_a <= most_a + each.step_a:
            yield Finding(
                (*each.path, "trip"),
                f"at full duty the heater takes {about(most_a)} A, and the sensor's step is "
                f"{about(each.step_a)} A, so {number(over_a)} A would be reached on a healthy "
                "machine",
                f"Use at least {rounded_up(most_a + 2 * each.step_a)} A",
                (("outputs", each.name), ("sensors", each.current.sensor)),
            )


def limits_can_begin(controller: Controller) -> Findings:
    """Find heaters so strong that the first duty under a current limit trips `over_current`."""
    for each in measured(controller):
        if each.current.limit_a is None or each.full_a is None:
            continue
        first_a = FIRST_SHARE * each.full_a
        if first_a + each.step_a >= each.current.over_a > each.current.limit_a:
            yield Finding(
                (*each.path, "limit"),
                f"a heater with a current limit starts at {FIRST_SHARE * 100:.0f} % duty, at "
                f"which this one takes {about(first_a)} A, and rule over_current trips at "
                f"{number(each.current.over_a)} A",
                "Use a larger limit or trip, or a weaker heater",
                (("outputs", each.name), ("sensors", each.current.sensor)),
            )


def limits_can_be_told(controller: Controller) -> Findings:
    """Find limits that hold a damaged wire at a current which may be read as no current.

    A wire of too little resistance may draw almost the trip current at the first duty; the limit
    then reduces the duty by the square of the current. A reading is off by half a step, the held
    current by twice that share. If that current is read as none, the heater restarts at the first
    duty again and again.
    """
    for each in measured(controller):
        limit_a, over_a = each.current.limit_a, each.current.over_a
        if limit_a is None or over_a <= limit_a:
            continue
        half_a, surely_a = each.step_a / 2, each.idle_a + each.step_a / 2
        held_a = FIRST_SHARE * limit_a**2 / (over_a + half_a)
        least_a = (surely_a + half_a) ** 2 / surely_a
        if held_a < least_a:
            coarse = IDLE_STEPS * each.step_a >= IDLE_SHARE * each.current.nominal_a
            yield Finding(
                ("sensors", each.current.sensor, "scale") if coarse else (*each.path, "trip"),
                f"if a damaged wire of {each.name} takes almost the {number(over_a)} A of rule "
                f"over_current when it starts, the limit holds it at a mean of {about(held_a)} A, "
                f"too near the {about(each.idle_a)} A that are read as no current",
                "Use a larger scale, or a larger limit"
                if coarse
                else f"Use at most {rounded_down(FIRST_SHARE * limit_a**2 / least_a - half_a)} A",
                (each.path, ("sensors", each.current.sensor)),
            )


def currents_can_be_read(controller: Controller) -> Findings:
    """Check that the sensor can read the trip, and can distinguish a current from no current."""
    for each in measured(controller):
        sensor: Path = ("sensors", each.current.sensor)
        because_of = (sensor, ("outputs", each.name), ("controller", "board"))
        readable_a = each.highest_a - LEAST_MARGIN_STEPS * each.step_a
        if each.sensor.offset_v < 0:
            yield Finding(
                (*sensor, "offset"),
                "a pin cannot read less than 0 V, so zero current would look like a current",
                "Use an offset of 0 V or more",
            )
        elif readable_a < each.current.over_a:
            yield Finding(
                (*sensor, "scale"),
                f"the sensor reads up to {about(max(readable_a, 0.0))} A, and rule over_current of "
                f"{each.name} trips at {number(each.current.over_a)} A",
                "Use a smaller scale, or a reference of more volts",
                because_of,
            )
        elif each.full_a is not None and 2 * each.idle_a > each.full_a:
            coarse = IDLE_STEPS * each.step_a >= IDLE_SHARE * each.current.nominal_a
            yield Finding(
                (*sensor, "scale") if coarse else each.path,
                f"at full duty {each.name} takes {about(each.full_a)} A, less than twice the "
                f"{about(each.idle_a)} A that are read as no current, so rule no_current would "
                "never trip",
                "Use a larger scale, or a reference of fewer volts"
                if coarse
                else "Use a smaller limit or trip",
                because_of,
            )


LONGEST_PERIOD_S = 1.0
"""Longest period: a current is checked once a period, so a short circuit may last this long."""


def currents_in_time(controller: Controller) -> Findings:
    """Check that the period is short enough for a short circuit, and long enough for readings."""
    for each in measured(controller):
        for name, loop in _loops_of(controller, each.name):
            path: Path = ("loops", name, "period")
            because_of: tuple[Path, ...] = (("sensors", each.current.sensor), each.path)
            readings = each.sensor.oversample
            needed_s = round(readings * TICK_S, 2)
            settled_s = 2 * needed_s if each.current.limit_a and readings > 1 else needed_s
            if loop.period_s > LONGEST_PERIOD_S:
                yield Finding(
                    path,
                    f"the current of {each.name} is checked once a period, and a short circuit "
                    f"must not last {loop.told_period}",
                    f"Use at most {duration(LONGEST_PERIOD_S)}",
                    because_of,
                )
            elif not loop.has_time_for(needed_s):
                yield Finding(
                    path,
                    f"{loop.told_period} is shorter than the {readings} "
                    f"readings of {each.current.sensor}, one every 10 ms, which take "
                    f"{duration(needed_s)}",
                    f"Use at least {duration(settled_s)}, or a smaller oversample of that sensor",
                    because_of,
                )
            elif round(loop.period_s, 6) < settled_s:
                yield Finding(
                    ("sensors", each.current.sensor, "oversample"),
                    f"after a change of duty the current settles in the first half of the period "
                    f"of {loop.told_period}: some of the {readings} readings, which take "
                    f"{duration(needed_s)}, would come before",
                    f"Use at most {max(1, math.floor(round(loop.period_s / TICK_S / 2, 6)))}, or a "
                    f"period of at least {duration(settled_s)}",
                    ((*each.path, "limit"), path),
                )


def currents_can_be_smoothed(controller: Controller) -> Findings:
    """Find pulses, and filters, that are too slow to give a mean current in the time available."""
    simulation = controller.simulation
    for each in measured(controller):
        if not each.output.frequency_hz:
            continue
        for name, loop in _loops_of(controller, each.name):
            longest_s = loop.period_s / each.current.filter_parts
            within = "a third of " if each.current.filter_parts > 1 else ""
            because_of: tuple[Path, ...] = (("loops", name, "period"), each.path)
            needed_hz = FILTER_PULSES / longest_s
            if each.output.frequency_hz < needed_hz:
                yield Finding(
                    ("outputs", each.name, "frequency"),
                    f"the filter for the mean current needs {FILTER_PULSES} pulses in {within}the "
                    f"period of {loop.told_period}, and {hertz(each.output.frequency_hz)} gives "
                    "fewer",
                    f"Use at least {rounded_up(needed_hz)} Hz, or a longer period",
                    because_of,
                )
            sense = simulation.plant.sense.get(each.current.sensor) if simulation else None
            whole_s = math.floor(1000 * longest_s) / 1000
            if sense is not None and sense.lag_s > longest_s:
                yield Finding(
                    ("simulation", "plant", "sense", each.current.sensor, "lag"),
                    f"a filter of {duration(sense.lag_s)} does not follow the current within "
                    f"{within}a period of {loop.told_period}",
                    f"Use at most {duration(whole_s)}, or a longer period",
                    because_of,
                )


def _loops_of(controller: Controller, heater: str) -> Iterator[tuple[str, Loop]]:
    return ((name, loop) for name, loop in controller.loops.items() if loop.heater == heater)
