"""An SPI slave's end of its wires: bits in C, meaning in Python."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Protocol

from heatwright.sim.native.hw import Hw

PHASES = ("setup", "high", "low", "period", "read", "hold", "idle", "told", "kept")
"""What is judged of the master: from select to the first clock, the clock's high, its low, its
period, from an edge (or select) to the reading of its bit, from the last clock to the end of
select, the time not selected; of what it tells, from its last change to the edge that takes it, and
from there to its next change."""
WORD_BYTES, TOLD_BYTES = 16, 17
"""Longest answer; longest order, with its address."""


@dataclass(frozen=True)
class Timing:
    """Least times in ns, asked of the master.

    output, enable -- the slave's own: a bit is there so long after its edge, or after select.
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
class Phase:
    """A judged phase of the master's: shortest and longest seen, ns, and how often too short."""

    least: float
    most: float
    violations: int


@dataclass(frozen=True)
class Wires:
    """Pins of the processor, by port and bit, at a chip's wires.

    told -- at its input; None for a chip that only sends.
    """

    select: str
    clock: str
    data: str
    told: str | None = None


class Slave(Protocol):
    """A chip on the wires."""

    def selected(self, cycle: int) -> None:
        """Load what is to be sent; a chip with registers waits for their address."""

    def released(self, cycle: int) -> None:
        """Advance by itself; a chip with registers takes what it was told."""


class Registers(Slave, Protocol):
    """A chip with registers."""

    def addressed(self, address: int, cycle: int) -> None:
        """Load what stands from an address on, or nothing if it is to be written."""


class Port:
    """A slave's end of select, clock, data, and perhaps what it is told."""

    def __init__(self, hw: Hw, port: Any) -> None:
        self._hw = hw
        self._lib = hw.lib
        self._port = port

    def load(self, word: int, bits: int, driven: int | None = None) -> None:
        """Send a word, highest bit first; only the first `driven` bits are driven, then it floats.

        Call it from ``selected``, or from ``addressed``.
        """
        data = (word << (8 * WORD_BYTES - bits)).to_bytes(WORD_BYTES, "big")
        self._lib.hw_spi_load(self._port, data, bits if driven is None else driven)

    @property
    def told(self) -> bytes:
        """The whole bytes that came since it was selected last, an address first."""
        into = self._hw.ffi.new("uint8_t[]", TOLD_BYTES)
        count = self._lib.hw_spi_told(self._port, into)
        return bytes(self._hw.ffi.buffer(into, count))

    def connect(self, connected: bool) -> None:
        """Plug the slave in, or pull it off its wires."""
        self._lib.hw_spi_connect(self._port, connected)

    def retime(self, timing: Timing) -> None:
        """Use other times from now on."""
        self._lib.hw_spi_retime(self._port, _cycles(self._hw, timing))

    @property
    def phases(self) -> dict[str, Phase]:
        """What the master has done so far; a phase not seen yet is left out."""
        seen: dict[str, Phase] = {}
        for check, name in enumerate(PHASES):
            least = self._lib.hw_spi_seen(self._port, check, self._lib.HW_SPI_LEAST)
            most = self._lib.hw_spi_seen(self._port, check, self._lib.HW_SPI_MOST)
            wrong = self._lib.hw_spi_violations(self._port, check)
            if least <= most:
                seen[name] = Phase(self._ns(least), self._ns(most), wrong)
        return seen

    @property
    def violations(self) -> int:
        """How often the master has left the limits."""
        return sum(phase.violations for phase in self.phases.values())

    def _ns(self, cycles: int) -> float:
        return cycles * 1e9 / self._hw.clock_hz


_FIELDS = tuple(Timing.__dataclass_fields__)


def _cycles(hw: Hw, timing: Timing) -> Any:
    """Whole cycles that last at least so long; 100 ns at 20 MHz are two, whatever 100e-9 is."""
    cycles = hw.ffi.new("hw_spi_timing *")
    for field in _FIELDS:
        setattr(cycles, field, math.ceil(round(getattr(timing, field) * hw.clock_hz / 1e9, 6)))
    return cycles


def attach(
    hw: Hw, pins: tuple[int, ...], slave: Slave, timing: Timing, errors: list[BaseException]
) -> Port:
    """Put a slave on its select, clock and data pins, and the one that tells it something (or -1).

    What it raises is collected in errors.
    """
    handle = hw.ffi.new_handle((slave, errors))
    port = hw.lib.hw_spi_new(hw.pointer, pins, handle, _cycles(hw, timing))
    if not port:
        raise ValueError("There are too many SPI chips on these pins or this processor.")
    hw.kept.append(handle)
    return Port(hw, port)


def install(ffi: Any) -> None:
    """Make the shim call the slaves."""

    def hw_spi_selected(handle: Any, cycle: int) -> None:
        slave, errors = ffi.from_handle(handle)
        try:
            slave.selected(cycle)
        except BaseException as error:  # C cannot pass it on: Avr.run_to does
            errors.append(error)

    def hw_spi_released(handle: Any, cycle: int) -> None:
        slave, errors = ffi.from_handle(handle)
        try:
            slave.released(cycle)
        except BaseException as error:  # as above
            errors.append(error)

    def hw_spi_addressed(handle: Any, address: int, cycle: int) -> None:
        slave, errors = ffi.from_handle(handle)
        try:
            slave.addressed(address, cycle)
        except BaseException as error:  # as above
            errors.append(error)

    ffi.def_extern()(hw_spi_selected)
    ffi.def_extern()(hw_spi_released)
    ffi.def_extern()(hw_spi_addressed)
