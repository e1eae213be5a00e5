"""An SPI slave on its wires: C handles the bits, Python their meaning."""

import math
from dataclasses import dataclass
from typing import Any, Protocol

from heatwright.sim.native.hw import Hw
from heatwright.sim.native.master import Checked, callback

PHASES = ("setup", "high", "low", "period", "read", "hold", "idle", "told", "kept")
"""Checked times of the master: from select to the first clock; the clock's high, low and period;
from an edge (or select) to the reading of its bit; from the last clock to the end of select; the
time not selected; for its data line, from the last change to the edge that samples it, and from
there to the next change."""
WORD_BYTES, TOLD_BYTES = 16, 17
"""Longest answer, and longest message from the master with its address, bytes."""


@dataclass(frozen=True)
class Timing:
    """Minimum times, ns, that the master must keep.

    output, enable -- the slave's own delays: a bit is valid so long after its edge, or select.
    """

    setup: float = 100
    high: float = 100
    low: float = 100
    period: float = 200
    hold: float = 0
    idle: float = 0
    told: float = 0
    kept: float = 0
    output: float = 100
    enable: float = 100


@dataclass(frozen=True)
class Wires:
    """The processor's pins at a chip's wires, by port and bit.

    told -- the pin at the chip's input; None for a chip that only sends.
    """

    select: str
    clock: str
    data: str
    told: str | None = None


class Slave(Protocol):
    """A chip on the wires.

    A chip with registers has also `addressed(address, cycle)`: it loads the answer, the registers
    from an address on; nothing if the master writes to them.
    """

    def selected(self, cycle: int) -> None:
        """Load the data to send; a chip with registers waits for an address."""

    def released(self, cycle: int) -> None:
        """Act on the end of a transfer; a chip with registers stores the received data."""


class Port(Checked):
    """A slave's end of select, clock, data output and, if any, data input; times are in ns."""

    def __init__(self, hw: Hw, port: Any) -> None:
        super().__init__(hw, hw.lib.hw_spi_checks(port), PHASES, 1e9)
        self._port = port

    def load(self, word: int, bits: int, driven: int | None = None) -> None:
        """Send a word, highest bit first; only the first `driven` bits are driven, then it floats.

        Call it from ``selected``, or from ``addressed``.
        """
        data = (word << (8 * WORD_BYTES - bits)).to_bytes(WORD_BYTES, "big")
        self._lib.hw_spi_load(self._port, data, bits if driven is None else driven)

    @property
    def told(self) -> bytes:
        """The whole bytes received since it was last selected, beginning with an address."""
        into = self._hw.ffi.new("uint8_t[]", TOLD_BYTES)
        count = self._lib.hw_spi_told(self._port, into)
        return bytes(self._hw.ffi.buffer(into, count))

    def connect(self, connected: bool) -> None:
        """Connect the slave to its wires, or disconnect it."""
        self._lib.hw_spi_connect(self._port, connected)

    def retime(self, timing: Timing) -> None:
        """Use other times from now on."""
        self._lib.hw_spi_retime(self._port, _cycles(self._hw, timing))


_FIELDS = tuple(Timing.__dataclass_fields__)


def _cycles(hw: Hw, timing: Timing) -> Any:
    """Round times up to whole cycles: 100 ns at 20 MHz are two, although 100e-9 is inexact."""
    cycles = hw.ffi.new("hw_spi_timing *")
    for field in _FIELDS:
        setattr(cycles, field, math.ceil(round(getattr(timing, field) * hw.clock_hz / 1e9, 6)))
    return cycles


def attach(hw: Hw, pins: tuple[int, ...], slave: Slave, timing: Timing) -> Port:
    """Put a slave on its select, clock and data pins, and on its input's pin (or -1).

    Its exceptions are collected in `hw.errors`.
    """
    handle = hw.ffi.new_handle((slave, hw.errors))
    port = hw.lib.hw_spi_new(hw.pointer, pins, handle, _cycles(hw, timing))
    if not port:
        raise ValueError("There are too many SPI chips on these pins or this processor.")
    hw.kept.append(handle)
    return Port(hw, port)


def install(ffi: Any) -> None:
    """Register the callbacks of the slaves with the shim."""
    callback(ffi, "hw_spi_selected", lambda slave, cycle: slave.selected(cycle))
    callback(ffi, "hw_spi_released", lambda slave, cycle: slave.released(cycle))
    callback(ffi, "hw_spi_addressed", lambda slave, address, cycle: slave.addressed(address, cycle))
