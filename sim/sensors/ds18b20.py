"""A DS18B20 thermometer at the end of a 1-Wire line (Maxim data sheet 19-7487, rev. 6).

It has all ROM and function commands, the conversion times, the scratchpad with its CRC, and the
faults of such a sensor. It is supplied by its own wire, not by the line.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass
from functools import cache

from heatwright.sim.avr import Avr
from heatwright.sim.native.one_wire import Line, Timing
from heatwright.sim.native.tip import Tip
from heatwright.spec import Board
from heatwright.spec import Ds18b20 as Spec

FAMILY = 0x28
POWER_ON_RAW = 0x0550
"""85 °C, the value in the scratchpad before the first conversion."""
RESERVED = (0xFF, 0x0C, 0x10)
CONVERSION_S = {9: 0.09375, 10: 0.1875, 11: 0.375, 12: 0.75}
"""Longest conversion, by resolution in bit."""
COPY_S = 0.010
"""Longest time to copy the settings to the chip's EEPROM."""
LEAST_C, MOST_C = -55.0, 125.0

READ_ROM, MATCH_ROM, SKIP_ROM, SEARCH_ROM, ALARM_SEARCH = 0x33, 0x55, 0xCC, 0xF0, 0xEC
CONVERT, WRITE, READ, COPY, RECALL, SUPPLY = 0x44, 0x4E, 0xBE, 0x48, 0xB8, 0xB4


@cache
def _crc_of(byte: int) -> int:
    for _ in range(8):
        byte = byte >> 1 ^ (0x8C if byte & 1 else 0)
    return byte


def crc8(data: bytes) -> int:
    """Return the 1-Wire CRC: x8 + x5 + x4 + 1, lowest bit first, starting from 0."""
    crc = 0
    for byte in data:
        crc = _crc_of(crc ^ byte)
    return crc


def rom_code(serial: int) -> bytes:
    """Return the 8-byte code of a DS18B20 with this serial number (48 bit)."""
    body = bytes([FAMILY]) + serial.to_bytes(6, "little")
    return body + bytes([crc8(body)])


def raw_code(temperature_c: float, resolution_bits: int, undefined: int = 0b111) -> int:
    """Return the code of a temperature, 1/16 K; undefined -- the bits below the resolution."""
    step = 1 << (12 - resolution_bits)
    limited_c = min(max(temperature_c, LEAST_C), MOST_C)
    return math.floor(limited_c * 16 / step + 0.5) * step | (step - 1 & undefined)


@dataclass
class Faults:
    """Ways to fail, set at any time.

    frozen -- conversions do not change the reading; idle -- no conversion starts; weak -- the
    supply fails in the middle of each conversion; slow -- factor on the data sheet's longest
    conversion time; corrupt_next -- number of the next reads of the scratchpad with a wrong bit;
    corrupt_rate -- share of reads with a wrong bit (0..1, seeded).
    """

    frozen: bool = False
    idle: bool = False
    weak: bool = False
    slow: float = 1.0
    corrupt_next: int = 0
    corrupt_rate: float = 0.0


@dataclass
class _Settings:
    """TH, TL and configuration, as in the chip's EEPROM: 75 °C, 70 °C, 12 bit when new."""

    alarms: bytes = bytes([75, 70])
    resolution_bits: int = 12

    @property
    def raw(self) -> bytes:
        return self.alarms + bytes([(self.resolution_bits - 9) << 5 | 0x1F])

    @staticmethod
    def of(raw: bytes) -> _Settings:
        return _Settings(raw[:2], 9 + (raw[2] >> 5 & 3))


@dataclass
class _Conversion:
    ends: int
    raw: int | None
    """None: the conversion ends with a failing supply."""


class Ds18b20:
    """A chip on a pin of a processor.

    tip -- its temperature: a conversion samples it at its start; undefined_bits -- bits of a
    reading below the resolution; faults -- see Faults; line -- the 1-Wire line.
    """

    def __init__(
        self, avr: Avr, pin: str, *, serial: int = 1, timing: Timing | None = None
    ) -> None:
        self.tip = Tip(avr)
        self.undefined_bits = 0b111
        self.faults = Faults()
        self.rom = rom_code(serial)
        self.conversions = 0
        self._avr = avr
        self._pin = pin
        self._random = random.Random(serial)  # noqa: S311 - noise, not a secret
        self._eeprom = _Settings()
        self._power_on()
        self.line: Line = avr.one_wire(pin, self, timing)

    @property
    def violations(self) -> dict[str, int]:
        """Count violations of the data sheet's timing, by phase."""
        return {phase: seen.violations for phase, seen in self.line.phases.items()}

    def sense(self, temperature_c: float) -> None:
        """Set its tip's temperature from now on, °C."""
        self.tip.tell(temperature_c)

    # -- faults --------------------------------------------------------------------------------

    def unplug(self) -> None:
        """Disconnect the chip from the line and its supply."""
        self.line.connect(False)

    def plug(self) -> None:
        """Plug the chip in again: it starts again."""
        self.brown_out()
        self.line.connect(True)

    def short(self, level: str | None) -> None:
        """Short the line to ground ("low") or to supply ("high"); None removes the short."""
        if level not in {"low", "high", None}:
            raise ValueError(f"A line can be shorted low or high, not {level!r}.")
        self._avr.pins.drive(self._pin, "low" if level == "low" else "high" if level else None)

    def brown_out(self) -> None:
        """Interrupt the chip's supply: it loses its reading and loads its EEPROM's settings."""
        self._power_on()
        if hasattr(self, "line"):
            self.line.ignore()

    def _power_on(self) -> None:
        self._raw = POWER_ON_RAW
        self._settings = _Settings.of(self._eeprom.raw)
        self._conversion: _Conversion | None = None
        self._alarm = False
        self._selected = False
        self._writing = False

    # -- the line ------------------------------------------------------------------------------

    def received(self, first: bool, data: bytes, cycle: int) -> None:
        """Receive a command or its data from the master."""
        self._finish(cycle)
        if first:
            self._selected = self._writing = False
            self._rom_command(data[0])
        elif self._writing:
            self._writing = False
            self._settings = _Settings.of(data)
        elif not self._selected:
            self._chosen(data)
        else:
            self._function(data[0], cycle)

    def _rom_command(self, command: int) -> None:
        if command == SKIP_ROM:
            self._select()
        elif command == MATCH_ROM:
            self.line.receive(64)
        elif command == READ_ROM:
            self.line.send(self.rom)
        elif command == SEARCH_ROM or (command == ALARM_SEARCH and self._alarm):
            self.line.search(self.rom)

    def _chosen(self, rom: bytes) -> None:
        """Receive a 64-bit code: from Match ROM, or from a search that has reached this chip."""
        if rom == self.rom:
            self._select()

    def _select(self) -> None:
        self._selected = True
        self.line.receive(8)

    def _function(self, command: int, cycle: int) -> None:
        if command == CONVERT:
            self._convert(cycle)
        elif command == READ:
            self.line.send(self._scratchpad())
        elif command == WRITE:
            self._writing = True
            self.line.receive(24)
        elif command == COPY:
            self._eeprom = _Settings.of(self._settings.raw)
            self.line.busy(cycle + round(COPY_S * self._avr.clock_hz))
        elif command == RECALL:
            self._settings = _Settings.of(self._eeprom.raw)
        # SUPPLY reads as ones: not supplied by the line. Unknown commands read as ones, too.

    # -- measuring -----------------------------------------------------------------------------

    @property
    def conversion_s(self) -> float:
        """Duration of a conversion with the present settings, s."""
        return CONVERSION_S[self._settings.resolution_bits] * self.faults.slow

    def _convert(self, cycle: int) -> None:
        if self.faults.idle:
            return  # read slots give ones
        if self._conversion is None:
            self.conversions += 1
            lasts = round(self.conversion_s * self._avr.clock_hz)
            if self.faults.weak:
                self._conversion = _Conversion(cycle + lasts // 2, None)
            else:
                self._conversion = _Conversion(cycle + lasts, self._converted())
        self.line.busy(self._conversion.ends)

    def _converted(self) -> int:
        if self.faults.frozen:
            return self._raw
        return raw_code(self.tip.felt_c, self._settings.resolution_bits, self.undefined_bits)

    def _finish(self, cycle: int) -> None:
        done = self._conversion
        if done is None or cycle < done.ends:
            return
        if done.raw is None:
            self._power_on()
            return
        self._conversion = None
        self._raw = done.raw
        high, low = (
            int.from_bytes(self._settings.alarms[i : i + 1], "little", signed=True) for i in (0, 1)
        )
        self._alarm = not low < self._raw >> 4 < high

    def _scratchpad(self) -> bytes:
        body = (self._raw & 0xFFFF).to_bytes(2, "little") + self._settings.raw + bytes(RESERVED)
        return self._maybe_corrupt(body + bytes([crc8(body)]))

    def _maybe_corrupt(self, data: bytes) -> bytes:
        faults = self.faults
        if faults.corrupt_next:
            faults.corrupt_next -= 1
        elif not (faults.corrupt_rate and self._random.random() < faults.corrupt_rate):
            return data
        bit = self._random.randrange(8 * len(data))
        wrong = bytearray(data)
        wrong[bit // 8] ^= 1 << bit % 8
        return bytes(wrong)


def attach(avr: Avr, board: Board, sensor: Spec) -> Ds18b20:
    """Put a new chip on the sensor's pin, with the line's pull-up resistor."""
    return Ds18b20(avr, board.pins[sensor.pin].port_name)
