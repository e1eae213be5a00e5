"""Measured currents: their outputs, limits and trips, and the resolution of their sensors."""

from collections.abc import Iterator
from typing import NamedTuple

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.references import current_sensors
from heatwright.spec.controller import Controller
from heatwright.spec.outputs import Switch, full_rms_a
from heatwright.spec.problems import Path
from heatwright.spec.quantity import about, number, rounded_down, rounded_up
from heatwright.spec.sensing.circuits import reference_v
from heatwright.spec.sensing.conversion import CODES, LEAST_MARGIN_STEPS
from heatwright.spec.sensing.currents import Current, CurrentSensor

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
    current by twice that share. Read as no current, it would restart at the first duty for ever.
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
