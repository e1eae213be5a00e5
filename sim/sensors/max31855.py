"""A MAX31855 thermocouple converter (Maxim data sheet 19-5793, rev. 5).

It always converts in the background. A conversion that ends while it is not selected updates its
answer. After power-up it answers zeros until the first conversion has ended.
"""

import math

from heatwright.sim.avr import Avr
from heatwright.sim.native.spi import Timing
from heatwright.sim.sensors.spi_chip import SpiChip, Wire, Wires, wires_of
from heatwright.spec import Board
from heatwright.spec import Max31855 as Spec

LONGEST_S = 0.1
POWER_UP_S = 0.2
"""Time from power-on to the first conversion."""
LEAST_C, MOST_C = -270.0, 1800.0
THERMOCOUPLE_AT, INTERNAL_AT = 18, 4
"""Lowest bits of the two temperatures."""
FAULT, TO_SUPPLY, TO_GROUND, OPEN = 1 << 16, 1 << 2, 1 << 1, 1 << 0
ALWAYS_ZERO = (17, 3)
OPEN_CODE = 0x1FFF
"""The code while the thermocouple is open or shorted: all ones but the sign."""
TIMING = Timing(period=200, hold=100, idle=200, output=40, enable=100)
"""Serial interface timing: at most 5 MHz, 200 ns between two answers, otherwise 100 ns or less."""


def raw_code(temperature_c: float) -> int:
    """Return the code of the thermocouple's temperature, 0.25 K each, signed."""
    return math.floor(min(max(temperature_c, LEAST_C), MOST_C) * 4 + 0.5)


def internal_code(temperature_c: float) -> int:
    """Return the code of the chip's own temperature, 0.0625 K each, signed."""
    return math.floor(min(max(temperature_c, -55.0), 127.0) * 16 + 0.5)


class Max31855(SpiChip):
    """A chip on three pins of a processor (see SpiChip).

    internal_c -- the chip's own temperature, °C; shorted_to -- what its thermocouple touches.
    """

    longest_s = LONGEST_S
    bits = driven = 32
    corruptible = (*ALWAYS_ZERO, 16, 2, 1, 0)

    def __init__(self, avr: Avr, wires: Wires) -> None:
        self.internal_c = 25.0
        self.shorted_to: Wire | None = None
        super().__init__(avr, wires, timing=TIMING)

    def _power_on(self, cycle: int) -> None:
        self._answer = 0
        self._began = cycle + self._cycles(POWER_UP_S)

    def _go_on(self, cycle: int) -> None:
        ended = self._skip(cycle)
        if ended and not self.faults.frozen:
            self._answer = self._convert(self._felt_c(self._began - self._conversion_cycles))

    def released(self, cycle: int) -> None:
        """Discard the conversions that ended while it was selected."""
        self._skip(cycle)

    def _skip(self, cycle: int) -> int:
        """Advance to the conversion that is under way at a cycle; return how many have ended."""
        ended = max(0, (cycle - self._began) // self._conversion_cycles)
        self._began += ended * self._conversion_cycles
        return ended

    def _convert(self, temperature_c: float) -> int:
        code, faults = raw_code(temperature_c), self._fault_bits()
        if faults:
            code = OPEN_CODE
        internal = internal_code(self.internal_c) & 0xFFF
        return (code & 0x3FFF) << THERMOCOUPLE_AT | internal << INTERNAL_AT | faults

    def _fault_bits(self) -> int:
        if self.faults.open:
            return FAULT | OPEN
        if self.shorted_to is None:
            return 0
        return FAULT | (TO_GROUND if self.shorted_to == "ground" else TO_SUPPLY)

    def _word(self) -> int:
        return self._answer


def attach(avr: Avr, board: Board, sensor: Spec) -> Max31855:
    """Put a new chip on the sensor's pins."""
    return Max31855(avr, wires_of(board, sensor))
