"""A 1-Wire slave on its line: C handles the bits, Python their meaning."""

from dataclasses import dataclass
from typing import Any, Protocol

from heatwright.sim.native.hw import Hw
from heatwright.sim.native.master import Checked, callback

PHASES = ("reset_low", "reset_high", "slot", "recovery", "one_low", "zero_low", "read_at")
"""Checked times of the master: the low of a reset and the high after it, a slot's length, the high
between slots, the low of a 1 (or a read) and of a 0, and the time at which it samples a bit."""


@dataclass(frozen=True)
class Timing:
    """Times in µs. The first nine are limits for the master, the rest are the slave's own times."""

    reset_low: float = 480
    reset_high: float = 480
    slot: float = 60
    recovery: float = 1
    low_least: float = 1
    one_most: float = 15
    zero_least: float = 60
    zero_most: float = 120
    read_within: float = 15
    presence_wait: float = 30
    presence_low: float = 120
    sample: float = 30
    hold: float = 30


class Slave(Protocol):
    """A chip on the line."""

    def received(self, first: bool, data: bytes, cycle: int) -> None:
        """Receive bits from the master; first: they are the first since the reset."""


class Line(Checked):
    """A slave's end of the line; its checked times are in µs.

    After a reset pulse the shim itself answers with a presence pulse and receives 8 bits. In
    ``received`` the slave then decides what comes next, by a call of ``receive``, ``send``,
    ``busy``, ``search`` or ``ignore``.
    """

    def __init__(self, hw: Hw, wire: Any) -> None:
        super().__init__(hw, hw.lib.hw_onewire_checks(wire), PHASES, 1e6)
        self._wire = wire

    def receive(self, bits: int) -> None:
        """Receive a number of bits; they are given to ``received``, first bit lowest."""
        self._lib.hw_onewire_receive(self._wire, bits)

    def send(self, data: bytes) -> None:
        """Answer read slots with these bytes, then with ones."""
        self._lib.hw_onewire_send(self._wire, data, 8 * len(data))

    def busy(self, until: int) -> None:
        """Answer read slots with 0 until a cycle, then with 1."""
        self._lib.hw_onewire_busy(self._wire, until)

    def search(self, rom: bytes) -> None:
        """Take part in a search with this code; ``received`` is called if the master chooses it."""
        self._lib.hw_onewire_search(self._wire, rom)

    def ignore(self) -> None:
        """Do nothing until the next reset."""
        self._lib.hw_onewire_ignore(self._wire)

    def connect(self, connected: bool) -> None:
        """Connect the slave to the line, or disconnect it."""
        self._lib.hw_onewire_connect(self._wire, connected)

    def retime(self, timing: Timing) -> None:
        """Use other times from now on."""
        self._lib.hw_onewire_retime(self._wire, _cycles(self._hw, timing))

    @property
    def resets(self) -> int:
        """Number of reset pulses received."""
        return int(self._lib.hw_onewire_resets(self._wire))


_FIELDS = tuple(Timing.__dataclass_fields__)


def _cycles(hw: Hw, timing: Timing) -> Any:
    cycles = hw.ffi.new("hw_onewire_timing *")
    for field in _FIELDS:
        setattr(cycles, field, round(getattr(timing, field) * hw.clock_hz / 1e6))
    return cycles


def attach(hw: Hw, pin: int, slave: Slave, timing: Timing) -> Line:
    """Put a slave on a pin; its exceptions are collected in `hw.errors`."""
    handle = hw.ffi.new_handle((slave, hw.errors))
    wire = hw.lib.hw_onewire_new(hw.pointer, pin, handle, _cycles(hw, timing))
    if not wire:
        raise ValueError("There are too many 1-Wire chips on this pin or processor.")
    hw.kept.append(handle)
    return Line(hw, wire)


def install(ffi: Any) -> None:
    """Register the callbacks of the slaves with the shim."""

    def received(slave: Slave, first: int, data: Any, bits: int, cycle: int) -> None:
        slave.received(bool(first), ffi.buffer(data, (bits + 7) // 8)[:], cycle)

    callback(ffi, "hw_onewire_received", received)
