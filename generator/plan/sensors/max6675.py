"""MAX6675: a thermocouple of type K, 12 bit, no negative temperatures."""

from heatwright.generator.plan.converter import Chip, plan_converter
from heatwright.generator.plan.parts import Part
from heatwright.generator.plan.sensors.common import UseOfSensor
from heatwright.generator.plan.source import Source
from heatwright.spec import Max6675

POWER_UP_S = 0.0
"""The data sheet has no time: the chip converts as soon as it is not selected."""
SUPPLY = "5 V, with 100 nF; T- to its ground, or a broken thermocouple is not seen"


def plan(source: Source, name: str, sensor: Max6675, use: UseOfSensor) -> Part:
    """Plan the sensor and the reader of its wires."""
    return plan_converter(source, name, sensor, use, Chip("MAX6675", SUPPLY, power_up_s=POWER_UP_S))
