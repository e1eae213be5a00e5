"""A thermistor in its divider, on an ADC pin."""

from heatwright.sim.sensors.adc_sensor import AdcSensor, attach

__all__ = ["AdcSensor", "attach"]
