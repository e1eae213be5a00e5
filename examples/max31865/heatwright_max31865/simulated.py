"""A MAX31865 converter for platinum elements (Maxim data sheet 19-6478, rev. 3).

Only its wires are here, not its pin DRDY, which the firmware does without; and not the cycle of
tests that looks for broken wires one by one, which nobody asks it for. All its times are the
longest of the data sheet.
"""

from __future__ import annotations

from heatwright.sim.avr import Avr
from heatwright.sim.native.pins import Level
from heatwright.sim.native.spi import Timing
from heatwright.sim.sensors.spi_chip import Faults, SpiChip, Wires, wires_of
from heatwright.spec import Board
from heatwright_max31865.model import Max31865 as Spec

CONFIGURATION, RTD, UPPER, LOWER, STATUS = 0, 1, 3, 5, 7
POWER_ON = bytes([0, 0, 0, 0xFF, 0xFF, 0, 0, 0])
"""What the registers hold after the supply has come."""
WRITE = 0x80
BIAS, AUTOMATIC, ONCE, FORGET, FIFTY = 0x80, 0x40, 0x20, 0x02, 0x01
LASTING = 0xD1
"""Bits of the configuration that stay; the others clear themselves."""
HIGH, LOW, VOLTAGE = 0x80, 0x40, 0x04
UNSAID_LIMIT, UNSAID_STATUS = 0x01, 0x03
"""Bits of which the data sheet does not say what they are: here ones, which a program that goes by
them would notice."""
LARGEST = 0x7FFF
FIRST_S = {True: 0.066, False: 0.055}
NEXT_S = {True: 0.021, False: 0.0176}
"""Longest conversion with the filter for 50 Hz, and without: the first one, and those after it."""
SETTINGS_BITS = (*range(56, 64), *range(9, 16), *range(16, 24), *range(25, 32), *range(32, 40))
"""Bits of all registers in a row, 0 the last: those that the program has written."""
A, B, C = 3.9083e-3, -5.775e-7, -4.183e-12
TIMING = Timing(
    setup=400, high=100, low=100, period=200, hold=100, idle=400, told=35, kept=35,
    output=80, enable=0,
)  # fmt: skip
"""Serial interface timing: at most 5 MHz."""


def resistance_ratio(temperature_c: float) -> float:
    """Return a platinum element's resistance in parts of that at 0 °C, as IEC 60751 has it."""
    t = temperature_c
    ratio = 1 + A * t + B * t * t
    return ratio + C * (t - 100) * t * t * t if t < 0 else ratio


class Max31865(SpiChip):
    """A chip on four pins of a processor (see SpiChip).

    full -- its reference in times of the element at 0 °C; shorted -- the element is; beyond_supply
    -- a terminal is above its supply or below ground, and it does not convert; misused -- orders
    that the data sheet forbids: another filter while it converts.
    """

    longest_s = 0.0  # its settings decide
    _began: int | None
    _first: bool
    bits = driven = 8 * len(POWER_ON)
    corruptible = SETTINGS_BITS

    def __init__(
        self, avr: Avr, wires: Wires, full: float, *, timing: Timing = TIMING, seed: int = 1
    ) -> None:
        self.full = full
        self.shorted = self.beyond_supply = False
        self.misused = 0
        super().__init__(avr, wires, timing=timing, seed=seed)

    def short_orders(self, level: Level | None) -> None:
        """Short its input to ground ("low") or to supply ("high"); None ends it."""
        assert self._wires.told is not None  # noqa: S101 - it has one
        self._avr.pins.drive(self._wires.told, level)

    def settle(self) -> None:
        """Do what has happened up to now without the fault that comes next."""
        self._go_on(self._avr.cycle)

    # -- the wires -----------------------------------------------------------------------------

    def selected(self, cycle: int) -> None:
        """Wait for an address; what it measures from now on it shows next time."""
        self._go_on(cycle)
        self._shown = bytes(self._registers)

    def addressed(self, address: int, cycle: int) -> None:
        """Load the registers from an address on, the first behind the last."""
        del cycle
        if address & WRITE:
            return
        self.reads += 1
        word = 0 if self.faults.dumb else self._maybe_corrupt(self._word())
        at, registers = address % len(POWER_ON), word.to_bytes(len(POWER_ON), "big")
        answer = registers[at:] + registers[:at]
        self.port.load(int.from_bytes(answer, "big"), self.bits, self.driven)

    def released(self, cycle: int) -> None:
        """Take what was written."""
        told = self.port.told
        if self.faults.dumb or len(told) < 2 or not told[0] & WRITE:
            return
        self._go_on(cycle)
        for at, byte in enumerate(told[1:], start=told[0] & ~WRITE):
            if at == CONFIGURATION:
                self._configure(byte, cycle)
            elif UPPER <= at < STATUS:
                self._registers[at] = byte | UNSAID_LIMIT * (at in {UPPER + 1, LOWER + 1})

    def _configure(self, asked: int, cycle: int) -> None:
        before = self._registers[CONFIGURATION]
        if before & asked & AUTOMATIC and (before ^ asked) & FIFTY:
            self.misused += 1
        if asked & FORGET:
            self._registers[STATUS] = UNSAID_STATUS
        self._registers[CONFIGURATION] = asked & LASTING
        if not asked & AUTOMATIC:
            self._began = cycle if asked & ONCE else None
            self._first = True
        elif not before & AUTOMATIC:
            self._began, self._first = cycle, True

    # -- measuring -----------------------------------------------------------------------------

    def _power_on(self, cycle: int) -> None:
        del cycle
        self._registers = bytearray(POWER_ON)
        self._registers[STATUS] = UNSAID_STATUS
        self._shown = bytes(self._registers)
        self._began = None
        self._first = True

    def _go_on(self, cycle: int) -> None:
        if self.beyond_supply:
            self._registers[STATUS] |= VOLTAGE
            if self._began is not None:
                self._began = cycle  # it stands still, and begins anew when that is over
        last: int | None = None
        while self._began is not None:
            fifty = bool(self._registers[CONFIGURATION] & FIFTY)
            took_s = (FIRST_S if self._first else NEXT_S)[fifty] * self.faults.slow
            if cycle < self._began + self._cycles(took_s):
                break
            last, self._first = self._began, False
            again = self._registers[CONFIGURATION] & AUTOMATIC
            self._began = self._began + self._cycles(took_s) if again else None
        if last is not None and not self.faults.frozen:
            self._convert(self._felt_c(last))
        self._tell_of_faults()

    def _convert(self, temperature_c: float) -> None:
        code = min(round(resistance_ratio(temperature_c) / self.full * (LARGEST + 1)), LARGEST)
        if self.faults.open:
            code = LARGEST
        elif self.shorted:
            code = 0
        self._registers[RTD : RTD + 2] = (code << 1).to_bytes(2, "big")
        upper, lower = (
            int.from_bytes(self._registers[at : at + 2], "big") >> 1 for at in (UPPER, LOWER)
        )
        self._registers[STATUS] |= HIGH * (code >= upper) | LOW * (code <= lower)

    def _tell_of_faults(self) -> None:
        """Set the bit below the code while there is anything in the status."""
        told = bool(self._registers[STATUS] & ~UNSAID_STATUS)
        self._registers[RTD + 1] = (self._registers[RTD + 1] & 0xFE) | told

    def _word(self) -> int:
        return int.from_bytes(self._shown, "big")


def attach(avr: Avr, board: Board, sensor: Spec) -> Max31865:
    """Put a new chip on the sensor's pins, and the element that was specified on it."""
    return Max31865(avr, wires_of(board, sensor), sensor.reference_ohm / sensor.ohm_at_0)


__all__ = ["Faults", "Max31865", "attach"]
