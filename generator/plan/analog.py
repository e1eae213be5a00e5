"""Common parts of thermistor, rtd and analog sensors: a channel, limits and a table."""

from dataclasses import dataclass
from typing import NamedTuple

from heatwright.generator.plan.adc import AdcNames, channel_macro, scan
from heatwright.generator.plan.core import rule_macro
from heatwright.generator.plan.numbers import c_float, quantity
from heatwright.generator.plan.parts import (
    Call,
    Constant,
    File,
    Group,
    Part,
    Stage,
    Symbol,
    Wiring,
    pair,
    pulled,
)
from heatwright.generator.plan.pins import label
from heatwright.generator.plan.sensors.common import UseOfSensor, summed
from heatwright.generator.plan.source import Source
from heatwright.spec import RULES, Analog, Divider, Rtd, Thermistor
from heatwright.spec.sensing.conversion import Conversion, conversion

RULE = {rule.id: rule_macro(rule) for rule in RULES.values()}


class Point(NamedTuple):
    """A line of the table; the last has no slope."""

    raw: int
    celsius: str
    slope: str


@dataclass(frozen=True, slots=True)
class AnalogNames:
    """Further values for the templates of an analog thermometer."""

    kind: str
    range_where: str
    at_low: str
    at_high: str
    points: list[Point]
    segments: int


def plan_analog(
    source: Source, name: str, sensor: Thermistor | Rtd | Analog, use: UseOfSensor, circuit: str
) -> Part:
    """Plan an analog sensor; `circuit` describes the circuit at the pin in a few ASCII words."""
    controller = source.controller
    board = controller.board
    pin = board.pins[sensor.pin]
    table = conversion(sensor, board.mcu)
    at_low, at_high = RULE["sensor_short"], RULE["sensor_open"]
    if not table.limits.open_is_high:
        at_low, at_high = at_high, at_low
    words = circuit[0].upper() + circuit[1:]
    points, within = _points(table), source.at("range").where
    told = (
        source.named(name),
        AdcNames(label(pin), words, channel_macro(name), sensor.oversample),
        AnalogNames(sensor.kind, within, at_low, at_high, points, len(points) - 1),
    )
    shared = scan(Source(source.spec, ()))
    return Part(
        files=(
            *shared.files,
            *pair(f"sensor_{name}", f"sensors/{sensor.kind}", told),
            File(f"src/celsius_{name}.c", "sensors/celsius.c.j2", told),
        ),
        groups=(Group(f"Sensor {name}", _constants(source, sensor, name, table, use)),),
        start_calls=shared.start_calls,
        tick_calls=(
            Call(Stage.SENSE, f"sensor_{name}.h", f"sensor_{name}_tick();"),
            *shared.tick_calls,
        ),
        wiring=(_wiring(label(pin), f"sensor `{name}`: {sensor.kind}", sensor, circuit),),
    )


def _wiring(pin: str, what: str, sensor: Thermistor | Rtd | Analog, circuit: str) -> Wiring:
    """Draw an element with its resistor; a sensor that gives a voltage is a box with a terminal."""
    divider = sensor.divider
    if divider is None:
        return Wiring(pin, what, circuit, end="out" if sensor.amplifier is None else "amplifier")
    rail = "5 V" if divider.supply_v is None else f"{divider.supply_v:g} V"
    element = circuit.partition(" to ")[0]
    if divider.pull_up_ohm is not None:
        resistor = pulled("up", f"{divider.pull_up_ohm:g} Ω", rail)
        sensed = Symbol("down", "sensor", element)
    else:
        resistor = pulled("down", f"{divider.pull_down_ohm:g} Ω")
        sensed = Symbol("up", "sensor", element, rail)
    return Wiring(pin, what, circuit, (resistor, sensed), ends=False)


def divider_words(element: str, divider: Divider | None) -> str:
    """Describe how an element is wired to its resistor."""
    assert divider is not None  # noqa: S101 - a checked spec has one
    supply = "the supply" if divider.supply_v is None else f"{divider.supply_v:g} V"
    if divider.pull_up_ohm is not None:
        return f"{element} to ground, {divider.pull_up_ohm:g} ohm to {supply}"
    return f"{element} to {supply}, {divider.pull_down_ohm:g} ohm to ground"


def _points(table: Conversion) -> list[Point]:
    slopes = [c_float(slope) for slope in table.slopes]
    return [
        Point(point.raw, c_float(point.celsius), slope)
        for point, slope in zip(table.points, [*slopes, ""], strict=True)
    ]


def _constants(
    source: Source,
    sensor: Thermistor | Rtd | Analog,
    name: str,
    table: Conversion,
    use: UseOfSensor,
) -> tuple[Constant, ...]:
    prefix, limits = f"SENSOR_{name.upper()}", table.limits
    ends = sorted(sensor.range_c, reverse=table.points[0].celsius > table.points[-1].celsius)
    span = source.at("range")
    return (
        *summed(source, prefix, sensor.oversample, use),
        span.count(f"{prefix}_CODE_LOW", limits.low, quantity(ends[0], "degC")),
        span.count(f"{prefix}_CODE_HIGH", limits.high, quantity(ends[1], "degC")),
        Constant(
            f"{prefix}_CODE_FAR_LOW",
            f"{limits.far_low}u",
            f"halfway from CODE_LOW to {limits.low_limit}, the circuit's lowest code",
        ),
        Constant(
            f"{prefix}_CODE_FAR_HIGH",
            f"{limits.far_high}u",
            f"halfway from CODE_HIGH to {limits.high_limit}, the circuit's highest code",
        ),
    )
