"""Baud rates: the divisor of a serial port and the error it leaves."""

from typing import NamedTuple

LARGEST_DIVISOR = 4095
"""Largest divisor: the register UBRR has twelve bits."""

BAUD_TOLERANCE = 0.0225
"""Half of the tolerance of a receiver that samples 16 times a bit over the ten bits of a frame
(−4.5 %, +4.6 %: data sheet, table of receiver baud rate errors, 8 bits without parity); the other
half is for the other end. 115200 baud from 16 MHz, 2.1 % off, is within it."""


RECEIVED_TOLERANCE = 2 * BAUD_TOLERANCE
"""Largest error of the baud rate that a receiver tolerates if the other end's clock is right."""


class BaudSetting(NamedTuple):
    """The divisor register's value at double speed (U2X), and the rate it really gives."""

    divisor: int
    baud: float
    error: float
    """Relative error of the rate: 0.02 is 2 % too fast."""


def baud_setting(clock_hz: int, baud: int) -> BaudSetting:
    """Find the divisor nearest to a baud rate, at double speed."""
    divisor = min(max(round(clock_hz / (8 * baud)) - 1, 0), LARGEST_DIVISOR)
    actual = clock_hz / (8 * (divisor + 1))
    return BaudSetting(divisor, actual, actual / baud - 1)
