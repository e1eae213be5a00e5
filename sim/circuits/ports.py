"""Voltage at an ADC's pin: the sensing element, its circuit, and faults of the wiring."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from heatwright.sim.circuits.elements import SUPPLY_V, Array, element_ohm
from heatwright.spec import Amplifier, Analog, Board, CurrentSensor, Divider, Rtd, Thermistor

INTERNAL_REFERENCE_V = {
    "atmega328p": 1.1, "atmega32u4": 2.56, "atmega644p": 2.56, "atmega1284p": 2.56,
    "atmega2560": 2.56, "atmega32": 2.56, "atmega16": 2.56,
}  # fmt: skip
"""The ADC's internal reference with REFS1 and REFS0 both set (data sheets, ADC, "ADMUX")."""


@dataclass(frozen=True)
class Wiring:
    """Faults between element and pin; by default there are none.

    opened -- a wire to the element is broken; shorted -- the element's two wires touch;
    series_ohm -- a contact that corrodes; parallel_ohm -- a leak across the element; pin -- the
    pin's own wire touches ground ("low") or the supply ("high").
    """

    opened: bool = False
    shorted: bool = False
    series_ohm: float = 0.0
    parallel_ohm: float = np.inf
    pin: Literal["low", "high"] | None = None

    def ohm(self, of_element: Array) -> Array:
        """Return the resistance that the circuit sees of an element; infinite when opened."""
        if self.opened:
            return np.full_like(of_element, np.inf)
        if self.shorted:
            return np.zeros_like(of_element)
        return 1 / (1 / of_element + 1 / self.parallel_ohm) + self.series_ohm


SOUND = Wiring()


def pin_v(sensor: Thermistor | Rtd | Analog, celsius: ArrayLike, wiring: Wiring = SOUND) -> Array:
    """Return the voltage at the pin for temperatures at the element, °C."""
    temperature_c = np.asarray(celsius, dtype=float)
    if wiring.pin is not None:
        return np.full_like(temperature_c, 0.0 if wiring.pin == "low" else SUPPLY_V)
    if sensor.gives_voltage:
        return _given_v(sensor, temperature_c, wiring)
    seen_ohm = wiring.ohm(element_ohm(sensor, temperature_c))
    if sensor.amplifier is not None:
        return _amplified_v(sensor.element, sensor.amplifier, seen_ohm)
    assert sensor.divider is not None  # noqa: S101 - else there is an amplifier
    return _divided_v(sensor.divider, seen_ohm)


def current_v(sensor: CurrentSensor, amperes: ArrayLike, wiring: Wiring = SOUND) -> Array:
    """Return the voltage at a current sensor's pin, V; unplugged, its filter's capacitor is empty.

    wiring -- only its faults `opened` and `pin` apply.
    """
    flowing_a = np.asarray(amperes, dtype=float)
    if wiring.pin is not None or wiring.opened:
        return np.full_like(flowing_a, SUPPLY_V if wiring.pin == "high" else 0.0)
    return _within(sensor.offset_v + sensor.scale_v_per_a * flowing_a, SUPPLY_V)


def reference_v(sensor: Thermistor | Rtd | Analog | CurrentSensor, board: Board) -> float:
    """Return the ADC's full scale, V."""
    if isinstance(sensor.reference, float):
        return sensor.reference
    return SUPPLY_V if sensor.reference == "supply" else INTERNAL_REFERENCE_V[board.mcu]


def shares(sensor: Thermistor | Rtd | Analog, board: Board, celsius: ArrayLike) -> Array:
    """Return the voltage of a sound circuit as a share of the ADC's full scale."""
    return pin_v(sensor, celsius) / reference_v(sensor, board)


def _divided_v(divider: Divider, seen_ohm: Array) -> Array:
    """Return the voltage at the joint of two resistors: the mean of their ends' by conductance.

    J. Millman, "A useful network theorem", Proc. IRE 28 (1940).
    """
    supply_v = SUPPLY_V if divider.supply_v is None else divider.supply_v
    resistor_ohm = divider.pull_up_ohm or divider.pull_down_ohm
    resistor_s: Array = np.asarray(1 / float(resistor_ohm or np.nan))
    pulled_up = divider.pull_up_ohm is not None
    if not seen_ohm.all():
        short_v = 0.0 if pulled_up else supply_v
        sound_v = _divided_v(divider, np.where(seen_ohm == 0, np.nan, seen_ohm))
        return np.where(seen_ohm == 0, short_v, sound_v)
    element_s = 1 / seen_ohm
    upper_s, lower_s = (resistor_s, element_s) if pulled_up else (element_s, resistor_s)
    return supply_v * upper_s / (upper_s + lower_s)


def _amplified_v(element: str, amplifier: Amplifier, seen_ohm: Array) -> Array:
    """Return the gain times the element's voltage above that at R₀, between ground and supply.

    With plain resistors the current follows from Ohm's law for both in series.
    """
    full_v, series_ohm = amplifier.excitation_v, amplifier.series_ohm
    zero_ohm: Array = np.asarray({"pt100": 100.0, "pt1000": 1000.0}[element])
    if amplifier.feed == "resistors":
        dropped_v, zero_v = (
            full_v * series_ohm / (series_ohm + ohm) for ohm in (seen_ohm, zero_ohm)
        )
        return _within(amplifier.gain * (zero_v - dropped_v), full_v)
    return _within(amplifier.gain * full_v / series_ohm * (seen_ohm - zero_ohm), full_v)


def _given_v(sensor: Analog, temperature_c: Array, wiring: Wiring) -> Array:
    """Return the voltage of a sensor with a voltage output; unplugged, that of its open line."""
    open_v = SUPPLY_V if sensor.open_reads == "high" else 0.0
    if wiring.opened or wiring.shorted:
        return np.full_like(temperature_c, open_v if wiring.opened else SUPPLY_V - open_v)
    return _within(sensor.offset_v + sensor.scale_v_per_k * temperature_c, SUPPLY_V)


def _within(wanted_v: Array, supply_v: float) -> Array:
    """Limit a voltage to its supply; np.clip would take ten times as long for a single number."""
    return np.minimum(np.maximum(wanted_v, 0.0), supply_v)
