"""Sensor that gives a voltage, read by the ADC."""

from heatwright.generator.plan.analog import plan_analog
from heatwright.generator.plan.parts import Part
from heatwright.generator.plan.sensors.common import UseOfSensor
from heatwright.generator.plan.source import Source
from heatwright.spec import Analog


def plan(source: Source, name: str, sensor: Analog, use: UseOfSensor) -> Part:
    """Plan the sensor and its share of the ADC's scan."""
    circuit = f"{sensor.scale_v_per_k * 1000:g} mV/K, {sensor.offset_v:g} V at 0 degC"
    return plan_analog(source, name, sensor, use, circuit)
