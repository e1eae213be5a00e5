"""Current of a heater, on the ADC: a shunt's amplifier or a Hall sensor."""

import math

from heatwright.generator.plan.adc import CODES, AdcNames, channel_macro, scan
from heatwright.generator.plan.numbers import quantity
from heatwright.generator.plan.parts import Call, Constant, File, Group, Part, Stage, Wiring, pair
from heatwright.generator.plan.pins import label
from heatwright.generator.plan.sensors.common import UseOfSensor, summed
from heatwright.generator.plan.source import Source
from heatwright.spec import Controller, CurrentSensor
from heatwright.spec.sensing.circuits import reference_v
from heatwright.spec.sensing.currents import FILTER_PULSES


def plan(source: Source, name: str, sensor: CurrentSensor, use: UseOfSensor) -> Part:
    """Plan the sensor and its share of the ADC's scan."""
    controller = source.controller
    pin = controller.board.pins[sensor.pin]
    circuit = f"{quantity(sensor.scale_v_per_a, 'V/A')}, {quantity(sensor.offset_v, 'V')} at 0 A"
    own = AdcNames(label(pin), circuit, channel_macro(name), sensor.oversample)
    told = source.named(name), own
    shared = scan(Source(source.spec, ()))
    return Part(
        files=(
            *shared.files,
            *pair(f"sensor_{name}", "sensors/current", told),
            File(f"src/amperes_{name}.c", "sensors/amperes.c.j2", told),
        ),
        groups=(Group(f"Sensor {name}", _constants(source, sensor, name, use)),),
        start_calls=shared.start_calls,
        tick_calls=(
            Call(Stage.SENSE, f"sensor_{name}.h", f"sensor_{name}_tick();"),
            *shared.tick_calls,
        ),
        wiring=(
            Wiring(
                label(pin),
                f"sensor `{name}`: current",
                circuit + _filter(controller, name, use),
                end=circuit.partition(",")[0],
            ),
        ),
    )


def _constants(
    source: Source, sensor: CurrentSensor, name: str, use: UseOfSensor
) -> tuple[Constant, ...]:
    prefix = f"SENSOR_{name.upper()}"
    full_v = reference_v(sensor, source.controller.board.mcu)
    full, scale = quantity(full_v, "V"), quantity(sensor.scale_v_per_a, "V/A")
    return (
        *summed(source, prefix, sensor.oversample, use),
        source.at("scale").number(
            f"{prefix}_AMPERES_PER_COUNT",
            full_v / (CODES * sensor.oversample * sensor.scale_v_per_a),
            f"{full} / ({CODES} x {sensor.oversample} x {scale})",
        ),
        source.at("offset").number(
            f"{prefix}_AMPERES_AT_ZERO",
            (full_v * 0.5 / CODES - sensor.offset_v) / sensor.scale_v_per_a,
            f"({full} x 0.5 / {CODES} - {quantity(sensor.offset_v, 'V')}) / {scale}",
        ),
    )


def _filter(controller: Controller, name: str, use: UseOfSensor) -> str:
    """Return the filter needed between the sensor and the pin, if its heater is pulsed."""
    for loop in controller.loops.values():
        heater = controller.outputs[loop.heater]
        if heater.frequency_hz and heater.current and heater.current.sensor == name:
            least = quantity(FILTER_PULSES / heater.frequency_hz, "s")
            most = quantity(_rounded_down(use.loop.periods_s(1) / heater.current.filter_parts), "s")
            return f"; through an RC of {least} to {most}: the mean"
    return ""


def _rounded_down(seconds: float) -> float:
    """Round down to tenths of a millisecond, so that the printed time is within the allowed."""
    return math.floor(round(seconds * 1e4, 6)) / 1e4
