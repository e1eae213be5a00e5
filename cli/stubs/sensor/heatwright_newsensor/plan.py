"""A newsensor: its files, constants, pins and calls in the firmware."""

from __future__ import annotations

from heatwright.generator.plan.parts import Call, File, Part, Stage, Wiring
from heatwright.generator.plan.pins import driven, label
from heatwright.generator.plan.sensors.common import UseOfSensor
from heatwright.generator.plan.source import Source
from heatwright_newsensor.model import Newsensor


def plan(source: Source, name: str, sensor: Newsensor, use: UseOfSensor) -> Part:
    """Plan the sensor's files, constants, pins, calls and wires.

    source -- the sensor's place in the spec; `source.at(key)` is the place of one of its keys;
    name -- the sensor's name in the spec; sensor -- the sensor's keys; use -- how the firmware uses
    it, such as how often it is read.
    """
    pin = source.controller.board.pins[sensor.pin]
    context = {"name": name, "NAME": name.upper(), "pin": label(pin), "where": source.where}
    return Part(
        files=(
            File(f"src/sensor_{name}.h", "heatwright_newsensor:newsensor.h.j2", context),
            File(f"src/sensor_{name}.c", "heatwright_newsensor:newsensor.c.j2", context),
        ),
        groups=_constants(use),
        pins=(driven(source.at("pin"), f"sensor_{name}", pin, f"line of sensor {name}"),),
        start_calls=(Call(Stage.SENSE, f"sensor_{name}.h", f"sensor_{name}_start();"),),
        tick_calls=(Call(Stage.SENSE, f"sensor_{name}.h", f"sensor_{name}_tick();"),),
        wiring=(Wiring(label(pin), f"sensor `{name}`: newsensor", "its line"),),
    )


def _constants(use: UseOfSensor) -> tuple[()]:
    """Return the constants for config.h, each with its derivation."""
    raise NotImplementedError
