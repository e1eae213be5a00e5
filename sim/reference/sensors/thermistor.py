"""Sensor of kind `thermistor`: see heatwright.sim.reference.sensors.adc."""

from heatwright.sim.reference.sensors.adc import IdealSensor, converter

__all__ = ["IdealSensor", "converter"]
