"""A sensor with a voltage output, on an ADC pin."""

from heatwright.sim.sensors.adc_sensor import AdcSensor, attach

__all__ = ["AdcSensor", "attach"]
