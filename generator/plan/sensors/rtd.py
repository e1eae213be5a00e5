"""Platinum sensor in a divider or behind a differential amplifier, on the ADC."""

from heatwright.generator.plan.analog import divider_words, plan_analog
from heatwright.generator.plan.parts import Part
from heatwright.generator.plan.sensors.common import UseOfSensor
from heatwright.generator.plan.source import Source
from heatwright.spec import Rtd
from heatwright.spec.sensing.circuits import ZERO_OHM


def plan(source: Source, name: str, sensor: Rtd, use: UseOfSensor) -> Part:
    """Plan the sensor and its share of the ADC's scan."""
    return plan_analog(source, name, sensor, use, _circuit(sensor))


def _circuit(sensor: Rtd) -> str:
    element = sensor.element.title()
    if sensor.alpha_ppm_per_k is not None:
        element += f" of {sensor.alpha_ppm_per_k:g} ppm/K"
    if sensor.amplifier is None:
        return divider_words(element, sensor.divider)
    amplifier = sensor.amplifier
    volts, ohms = f"{amplifier.excitation_v:g} V", f"{amplifier.series_ohm:g} ohm"
    fed, inputs = f"with a constant current of {volts} / {ohms}", ""
    if amplifier.feed == "resistors":
        fed, inputs = f"from {volts} through {ohms}", ", by inputs that take no current"
    return (
        f"{element} and {ZERO_OHM[sensor.element]:g} ohm to ground, each fed {fed}; the "
        f"difference amplified {amplifier.gain:g} times{inputs}"
    )
