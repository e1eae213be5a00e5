"""Sensor of kind `rtd`: see heatwright.sim.reference.sensors.adc."""

from heatwright.sim.reference.sensors.adc import IdealSensor, converter

__all__ = ["IdealSensor", "converter"]
