"""Characters of a serial line, bit by bit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Parity = Literal["none", "even", "odd"]

CHARACTER = np.dtype(
    {
        "names": ["gap", "bit", "levels", "bits"],
        "formats": ["<f8", "<f8", "<u2", "u1"],
        "itemsize": 24,
    }
)
"""A character to the processor: cycles of silence before it, cycles of a bit, the levels of its
bits with the start bit lowest, and the number of bits."""

UART_BYTE = np.dtype(
    {
        "names": ["written", "end", "uart", "value", "lost", "format", "bit_cycles"],
        "formats": ["<u8", "<u8", "u1", "u1", "?", "u1", "<u4"],
        "itemsize": 24,
    }
)
"""A byte sent: the cycle it was written to UDR, the cycle its last stop bit ends, which UART, its
value, whether it was lost because transmitter and buffer were full, its format (see `Format.of`)
and the cycles of a bit."""

_PARITIES: tuple[Parity | None, ...] = ("none", None, "even", "odd")


def sent_by(uart: int, sent: NDArray[Any]) -> NDArray[Any]:
    """Return the UART_BYTE records that one UART has sent, without the lost bytes."""
    return sent[(sent["uart"] == uart) & ~sent["lost"]] if len(sent) else sent


@dataclass(frozen=True)
class Format:
    """How bytes are sent: data bits, parity, stop bits."""

    data_bits: int = 8
    parity: Parity = "none"
    stop_bits: int = 1

    @cached_property
    def bits(self) -> int:
        """Bits of a character, the start bit and the stop bits included."""
        return 1 + self.data_bits + (self.parity != "none") + self.stop_bits

    @cached_property
    def levels(self) -> NDArray[np.uint16]:
        """The levels of each byte's character, the start bit lowest."""
        data = np.arange(256, dtype=np.uint16) & ((1 << self.data_bits) - 1)
        stop = (1 << self.stop_bits) - 1
        levels = data << 1 | stop << (self.bits - self.stop_bits)
        if self.parity == "none":
            return levels.astype(np.uint16)
        ones = np.array([int(byte).bit_count() & 1 for byte in data], np.uint16)
        bit = ones ^ (self.parity == "odd")
        return (levels | bit << (1 + self.data_bits)).astype(np.uint16)

    @staticmethod
    @cache
    def of(code: int) -> Format:
        """Read the format of a UART_BYTE."""
        parity = _PARITIES[code >> 4 & 3]
        return Format(code & 15, parity or "none", 2 if code & 0x40 else 1)


EIGHT_N_ONE = Format()


def characters(
    data: bytes, form: Format, bit_cycles: float, gap: NDArray[Any], flips: Sequence[int]
) -> NDArray[Any]:
    """Return bytes as characters.

    gap -- cycles of silence before each, or one number for all; flips -- for each character, the
    bits that a disturbance inverts, the start bit lowest; empty: none.
    """
    made = np.zeros(len(data), CHARACTER)
    made["gap"] = gap
    made["bit"] = bit_cycles
    made["levels"] = form.levels[np.frombuffer(data, np.uint8)]
    if len(flips):
        made["levels"] ^= np.asarray(flips, np.uint16)
    made["bits"] = form.bits
    return made


def heard(sent: Any, form: Format, bit_cycles: float) -> tuple[int, bool]:
    """Return the value that a receiver reads from one UART_BYTE; whether parity and stop are right.

    It samples each bit once, in the middle, by its own clock from the edge of the start bit.
    """
    of = receiver(int(sent["format"]), int(sent["bit_cycles"]), form, bit_cycles)
    return of[int(sent["value"])]


@cache
def receiver(
    code: int, sent_cycles: int, form: Format, bit_cycles: float
) -> tuple[tuple[int, bool], ...]:
    """Return the results of `heard` for each value sent in a format (its code) at a baud rate."""
    own, ratio = Format.of(code), bit_cycles / sent_cycles
    return tuple(_sampled(own, value, ratio, form) for value in range(256))


def _sampled(own: Format, value: int, ratio: float, form: Format) -> tuple[int, bool]:
    """Receive a byte; ratio -- bit length of the receiver over that of the sender."""
    levels = int(own.levels[value])

    def sampled(bit: int) -> int:
        at = int((bit + 0.5) * ratio)
        return levels >> at & 1 if at < own.bits else 1

    found = sum(sampled(1 + bit) << bit for bit in range(form.data_bits))
    stop = 1 + form.data_bits + (form.parity != "none")
    right = sampled(0) == 0 and sampled(stop) == 1
    if form.parity != "none":
        ones = found.bit_count() + sampled(stop - 1)
        right = right and ones % 2 == (form.parity == "odd")
    return found, right
