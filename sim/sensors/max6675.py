"""A MAX6675 thermocouple converter (Maxim data sheet 19-2235, rev. 3).

It converts continuously while it is not selected. A selection aborts a conversion; the answer is
that of the last complete one. The data sheet does not define the answer before the first one: here
it is 0 °C.
"""

import math

from heatwright.sim.avr import Avr
from heatwright.sim.native.spi import Timing
from heatwright.sim.sensors.spi_chip import SpiChip, Wires, wires_of
from heatwright.spec import Board
from heatwright.spec import Max6675 as Spec

LONGEST_S = 0.22
MOST_CODE = 0xFFF
TEMPERATURE_AT = 3
"""Lowest bit of the temperature; above it a bit that is always 0."""
OPEN = 1 << 2
ALWAYS_ZERO = (15, 1)
"""The dummy sign and the device's identity."""
DRIVEN_BITS = 15
"""The last bit, D0, is three-state."""
TIMING = Timing(period=1e9 / 4.3e6, output=100, enable=100)
"""Serial interface timing: at most 4.3 MHz, otherwise 100 ns or less."""


def raw_code(temperature_c: float) -> int:
    """Return the code of a temperature, 0.25 K each, from 0 °C to 1023.75 °C."""
    return min(max(math.floor(temperature_c * 4 + 0.5), 0), MOST_CODE)


class Max6675(SpiChip):
    """A chip on three pins of a processor (see SpiChip)."""

    longest_s = LONGEST_S
    bits = 16
    driven = DRIVEN_BITS
    corruptible = ALWAYS_ZERO

    def __init__(self, avr: Avr, wires: Wires) -> None:
        super().__init__(avr, wires, timing=TIMING)

    def _power_on(self, cycle: int) -> None:
        self._answer = 0
        self._since = cycle

    def _go_on(self, cycle: int) -> None:
        ended = (cycle - self._since) // self._conversion_cycles
        if ended and not self.faults.frozen:
            began = self._since + (ended - 1) * self._conversion_cycles
            self._answer = self._convert(self._felt_c(began))

    def released(self, cycle: int) -> None:
        """Start a conversion, because the chip is no longer selected."""
        self._since = cycle

    def _convert(self, temperature_c: float) -> int:
        if self.faults.open:
            return MOST_CODE << TEMPERATURE_AT | OPEN
        return raw_code(temperature_c) << TEMPERATURE_AT

    def _word(self) -> int:
        return self._answer


def attach(avr: Avr, board: Board, sensor: Spec) -> Max6675:
    """Put a new chip on the sensor's pins."""
    return Max6675(avr, wires_of(board, sensor))
