"""A platinum sensor in its divider or with its amplifier, on an ADC pin."""

from heatwright.sim.sensors.adc_sensor import AdcSensor, attach

__all__ = ["AdcSensor", "attach"]
