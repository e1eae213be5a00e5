"""A MAX31856 thermocouple converter (Maxim data sheet 19-7534, rev. 0): registers and conversions.

Its pins DRDY and FAULT are left out, because the firmware does not use them. It measures the
voltage of the connected thermocouple and converts it by the type that is set: a wrong type gives
wrong readings. All its times are the longest of the data sheet.
"""

import math

from heatwright.sim.avr import Avr
from heatwright.sim.native.pins import Level
from heatwright.sim.native.spi import Timing
from heatwright.sim.sensors.max31856_registers import (
    CJ_RANGE,
    CJTH,
    CJTL,
    LTCBH,
    LTCBL,
    OPEN,
    OVUV,
    POWER_ON,
    SETTINGS_BITS,
    SR,
    TC_RANGE,
    TYPES,
    UNSAID_CJTL,
    UNSAID_LTCBL,
    Settings,
    junction_c,
    threshold_bits,
)
from heatwright.sim.sensors.spi_chip import Faults, SpiChip, Wires, wires_of
from heatwright.sim.sensors.thermovoltage import Type, celsius, millivolts
from heatwright.spec import Board
from heatwright.spec import Max31856 as Spec

RANGES_C = {
    "B": (250.0, 1820.0), "E": (-200.0, 1000.0), "J": (-210.0, 1200.0), "K": (-200.0, 1372.0),
    "N": (-200.0, 1300.0), "R": (-50.0, 1768.0), "S": (-50.0, 1768.0), "T": (-200.0, 400.0),
}  # fmt: skip
"""The range of each type; beyond an end the chip sets a fault bit, and gives the end."""
JUNCTION_C = (-55.0, 125.0)
"""The range of the chip's own thermometer, with the same behaviour at the ends."""
TEST_EVERY = 16
"""The chip tests for an open thermocouple once in this number of conversions."""
STEP_C, JUNCTION_STEP_C = 2.0**-7, 2.0**-6
WRITE = 0x80
"""Added to the address of the first register in a write."""
TIMING = Timing(
    setup=100, high=100, low=100, period=200, hold=100, idle=400, told=35, kept=35,
    output=80, enable=0,
)  # fmt: skip
"""Serial interface timing: at most 5 MHz."""


def code_of(temperature_c: float, step_c: float) -> int:
    """Return the signed code of a temperature; step_c -- kelvin per code."""
    return math.floor(temperature_c / step_c + 0.5)


class Max31856(SpiChip):
    """A chip on four pins of a processor (see SpiChip).

    wire -- the type of the connected thermocouple; internal_c -- the temperature of the chip and of
    the cold junction, °C; held -- whether an open input keeps its voltage, as its capacitor does
    for a while, or has the bias, 0 mV; beyond_supply -- whether a terminal is above its supply or
    below ground; orders -- number of accepted writes; misused -- number of writes that the data
    sheet forbids: another mains filter while it converts.
    """

    longest_s = 0.0  # set by the registers: see Settings
    bits = driven = 8 * len(POWER_ON)
    corruptible = SETTINGS_BITS
    _began: int | None
    _settings: Settings

    def __init__(self, avr: Avr, wires: Wires, *, wire: Type = "K") -> None:
        self.wire: Type = wire
        self.internal_c = 25.0
        self.held = True
        self.orders = self.misused = 0
        self._beyond_supply = False
        self._faults = Faults()
        self._wired = False
        super().__init__(avr, wires, timing=TIMING)
        self._wired = True

    # -- faults: each first advances to now, as the past was without the new fault --------------

    @property
    def faults(self) -> Faults:
        """Ways to fail, set at any time."""
        self._settle()
        return self._faults

    @faults.setter
    def faults(self, faults: Faults) -> None:
        self._settle()
        self._faults = faults

    @property
    def beyond_supply(self) -> bool:
        """Whether a terminal is above its supply or below ground."""
        return self._beyond_supply

    @beyond_supply.setter
    def beyond_supply(self, beyond: bool) -> None:
        self._settle()
        self._beyond_supply = beyond

    def short_orders(self, level: Level | None) -> None:
        """Short its data input to ground ("low") or to supply ("high"); None removes the short."""
        assert self._wires.told is not None  # noqa: S101 - it has one
        self._avr.pins.drive(self._wires.told, level)

    def _settle(self) -> None:
        if self._wired:
            self._go_on(self._avr.cycle)

    @property
    def untested(self) -> int:
        """Conversions since its last test for an open thermocouple, or since the start."""
        self._settle()
        return self._count % TEST_EVERY

    # -- the wires -----------------------------------------------------------------------------

    def selected(self, cycle: int) -> None:
        """Copy the registers for the answer: later results are shown at the next selection."""
        self._go_on(cycle)
        self._shown = self._status(bytes(self._registers))

    def addressed(self, address: int, cycle: int) -> None:
        """Load the answer to a read: all registers from `address` on, the first after the last."""
        del cycle
        if address & WRITE:
            return
        self.reads += 1
        word = 0 if self._faults.dumb else self._maybe_corrupt(self._word())
        at, registers = address % len(POWER_ON), word.to_bytes(len(POWER_ON), "big")
        answer = registers[at:] + registers[:at]
        self.port.load(int.from_bytes(answer, "big"), self.bits, self.driven)

    def released(self, cycle: int) -> None:
        """Execute a write that has ended."""
        told = self.port.told
        if self._faults.dumb or len(told) < 2 or not told[0] & WRITE:
            return
        self._go_on(cycle)
        self.orders += 1
        self._write(told[0] & ~WRITE, told[1:])
        self._obey(cycle)

    def _write(self, place: int, data: bytes) -> None:
        for at, byte in enumerate(data, start=place):
            if Settings(bytes(self._registers)).may_write(at):
                self._registers[at] = byte

    def _obey(self, cycle: int) -> None:
        """Apply the registers' settings from now on."""
        before, asked = self._settings, Settings(bytes(self._registers))
        self._settings = asked
        if not before.automatic:
            self._filters_hz = asked.mains_hz
        self.misused += asked.automatic and asked.mains_hz != self._filters_hz
        if asked.clears_faults and asked.keeps_faults:
            self._registers[SR] = 0
        self._registers[0] = asked.lasting
        if not asked.automatic and not asked.once:
            self._began = None
        elif asked.once or not before.automatic:
            self._began, self._count = cycle, 0

    # -- measuring -----------------------------------------------------------------------------

    def was_told(self, settings: bytes) -> None:
        """Set these settings, CR0 first, as if they had been written some time ago."""
        self._power_on(self._avr.cycle)
        self._write(0, settings)
        self._obey(self._avr.cycle)

    def _power_on(self, cycle: int) -> None:
        del cycle
        self._registers = bytearray(POWER_ON)
        self._settings = Settings(POWER_ON)
        self._shown = bytes(POWER_ON)
        self._began = None
        self._count = 0
        self._open = False
        self._voltage_mv = 0.0
        self._filters_hz = self._settings.mains_hz

    def _go_on(self, cycle: int) -> None:
        settings = self._settings
        last: int | None = None
        while self._began is not None:
            tested = (self._count + 1) % TEST_EVERY == 0
            took_s = settings.next_s if self._count else settings.first_s
            took_s += settings.test_s * tested
            lasts = self._cycles(took_s * self._faults.slow)
            alone = tested or not self._count or not settings.automatic
            alike = 1 if alone else TEST_EVERY - 1 - self._count % TEST_EVERY
            ended = min(alike, (cycle - self._began) // lasts)
            if ended < 1:
                break
            if self._beyond_supply:
                self._began = cycle  # it stops, and starts again after that
                break
            last = self._began + ended * lasts
            self._began = last if settings.automatic else None
            self._count += ended
            if tested:
                self._open = settings.tests_open and self._faults.open
        if last is not None and not self._faults.frozen:
            self._convert(last)

    def _convert(self, ended: int) -> None:
        settings = self._settings
        own_c = min(max(self.internal_c, JUNCTION_C[0]), JUNCTION_C[1])
        flags = CJ_RANGE * (own_c != self.internal_c)
        if settings.measures_junction:
            seen = code_of(own_c + settings.offset_c, JUNCTION_STEP_C)
            self._registers[CJTH : CJTL + 1] = ((seen << 2 & 0xFFFF) | UNSAID_CJTL).to_bytes(
                2, "big"
            )
        self._measure(ended)
        letter = TYPES[settings.type]
        seen_c = junction_c(self._registers)
        found_c = celsius(letter, self._voltage_mv, seen_c)
        least_c, most_c = RANGES_C[letter]
        limited_c = min(max(found_c, least_c), most_c)
        flags |= TC_RANGE * (limited_c != found_c) | OPEN * self._open
        code = code_of(limited_c, STEP_C)
        self._registers[LTCBH : LTCBL + 1] = ((code << 5 & 0xFFFFFF) | UNSAID_LTCBL).to_bytes(
            3, "big"
        )
        flags |= threshold_bits(bytes(self._registers))
        kept = self._registers[SR] if settings.keeps_faults else 0
        self._registers[SR] = kept | flags

    def _measure(self, ended: int) -> None:
        """Measure the voltage: the mean of the averaged samples, one in each mains cycle."""
        if self._faults.open:
            self._voltage_mv = self._voltage_mv if self.held else 0.0
            return
        settings = self._settings
        felt = [
            self._felt_c(ended - self._cycles((turn + 1) / settings.mains_hz))
            for turn in range(settings.samples)
        ]
        self._voltage_mv = millivolts(self.wire, sum(felt) / len(felt), self.internal_c)

    def _status(self, registers: bytes) -> bytes:
        """Return the registers with the fault bits that do not wait for a conversion."""
        flags = registers[SR] | OVUV * self._beyond_supply
        return registers[:SR] + bytes([flags])

    def _word(self) -> int:
        return int.from_bytes(self._shown, "big")


def attach(avr: Avr, board: Board, sensor: Spec) -> Max31856:
    """Put a new chip on the sensor's pins, with the thermocouple of the spec."""
    return Max31856(avr, wires_of(board, sensor), wire=sensor.thermocouple)
