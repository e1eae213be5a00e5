"""Thermistor in a resistor divider, on the ADC."""

from heatwright.generator.plan.analog import divider_words, plan_analog
from heatwright.generator.plan.parts import Part
from heatwright.generator.plan.sensors.common import UseOfSensor
from heatwright.generator.plan.source import Source
from heatwright.spec import Thermistor


def plan(source: Source, name: str, sensor: Thermistor, use: UseOfSensor) -> Part:
    """Plan the sensor and its share of the ADC's scan."""
    return plan_analog(source, name, sensor, use, divider_words("thermistor", sensor.divider))
