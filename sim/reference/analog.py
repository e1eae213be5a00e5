"""Sensor of kind `analog`: see heatwright.sim.reference.adc."""

from heatwright.sim.reference.adc import IdealSensor, converter

__all__ = ["IdealSensor", "converter"]
