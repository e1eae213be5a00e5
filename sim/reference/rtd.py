"""Sensor of kind `rtd`: see heatwright.sim.reference.adc."""

from heatwright.sim.reference.adc import IdealSensor, converter

__all__ = ["IdealSensor", "converter"]
