"""MAX31855: a thermocouple of the chip's type, 14 bit, with faults of the thermocouple."""

from heatwright.generator.plan.converter import Chip, plan_converter
from heatwright.generator.plan.parts import Part
from heatwright.generator.plan.sensors.common import UseOfSensor
from heatwright.generator.plan.source import Source
from heatwright.spec import Max31855

POWER_UP_S = 0.2
"""Conversion power-up time (data sheet)."""
SUPPLY = "3.3 V, with 100 nF; the thermocouple must not touch ground"
SHIFT = " through a level shifter to 3.3 V"


def plan(source: Source, name: str, sensor: Max31855, use: UseOfSensor) -> Part:
    """Plan the sensor and the reader of its wires."""
    chip = Chip(f"MAX31855{sensor.thermocouple}", SUPPLY, SHIFT, POWER_UP_S)
    return plan_converter(source, name, sensor, use, chip)
