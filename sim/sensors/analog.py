"""A sensor that gives a voltage, at a pin of the ADC."""

from heatwright.sim.sensors.adc_sensor import AdcSensor, attach

__all__ = ["AdcSensor", "attach"]
