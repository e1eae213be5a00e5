"""The registers of a MAX31856, as its data sheet lists them ("Internal Registers")."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise

from heatwright.sim.sensors.thermovoltage import Type

CR0, CR1, MASK, CJHF, CJLF, LTHFTH, LTHFTL, LTLFTH, LTLFTL, CJTO = range(10)
CJTH, CJTL, LTCBH, LTCBM, LTCBL, SR = range(10, 16)
POWER_ON = bytes([0, 3, 0xFF, 0x7F, 0xC0, 0x7F, 0xFF, 0x80, 0, 0, 0, 0, 0, 0, 0, 0])
"""The registers' values after power-on."""

CJ_RANGE, TC_RANGE, CJ_HIGH, CJ_LOW, TC_HIGH, TC_LOW, OVUV, OPEN = (
    1 << bit for bit in range(7, -1, -1)
)
"""Bits of SR."""
AUTOMATIC, ONCE, TESTS_OPEN, NO_JUNCTION, KEEPS, CLEARS, FIFTY = 0x80, 0x40, 0x30, 8, 4, 2, 1
"""Bits of CR0."""
TYPES: tuple[Type, ...] = ("B", "E", "J", "K", "N", "R", "S", "T")
"""Types in the order of their codes in CR1; codes from 8 on give a voltage, not simulated."""

SETTINGS_BITS = tuple(range(8 * (SR - CJTO), 8 * (SR + 1)))
"""The bits of the registers that the program writes; bit 0 is the last of all registers."""
UNSAID_LTCBL, UNSAID_CJTL = 0x1F, 0x03
"""Bits below those of the temperatures, which the data sheet does not define: here ones, so that a
test fails if a program uses them by mistake."""

FIRST_S = {50.0: (0.185, 2 / 50), 60.0: (0.155, 2 / 60)}
NEXT_S = {50.0: (0.11, 1 / 50), 60.0: (0.09, 1 / 60)}
"""By mains frequency: longest first conversion after a stop, and longest following one, each with
the time that each further sample adds, s."""
TEST_S = {0x00: 0.0, 0x10: 0.015, 0x20: 0.037, 0x30: 0.125}
"""Longest time that each kind of test for an open thermocouple adds to a conversion, s."""


@dataclass(frozen=True)
class Settings:
    """The settings in the registers."""

    registers: bytes

    @property
    def automatic(self) -> bool:
        """Whether it converts continuously."""
        return bool(self.registers[CR0] & AUTOMATIC)

    @property
    def once(self) -> bool:
        """Whether a single conversion is requested."""
        return not self.automatic and bool(self.registers[CR0] & ONCE)

    @property
    def lasting(self) -> int:
        """CR0 without its two bits that clear themselves."""
        return self.registers[CR0] & ~(ONCE | CLEARS)

    @property
    def tests_open(self) -> bool:
        """Whether it tests for an open thermocouple."""
        return bool(self.registers[CR0] & TESTS_OPEN)

    @property
    def measures_junction(self) -> bool:
        """Whether it measures the cold junction itself; or the program writes the temperature."""
        return not self.registers[CR0] & NO_JUNCTION

    @property
    def keeps_faults(self) -> bool:
        """Whether bits of SR stay until they are cleared."""
        return bool(self.registers[CR0] & KEEPS)

    @property
    def clears_faults(self) -> bool:
        """Whether the program requests that SR be cleared now."""
        return bool(self.registers[CR0] & CLEARS)

    @property
    def mains_hz(self) -> float:
        """The mains frequency that it filters out, Hz."""
        return 50.0 if self.registers[CR0] & FIFTY else 60.0

    @property
    def samples(self) -> int:
        """Number of samples that it averages."""
        return min(1 << (self.registers[CR1] >> 4 & 7), 16)

    @property
    def type(self) -> int:
        """Code of the thermocouple's type."""
        return self.registers[CR1] & 7

    @property
    def offset_c(self) -> float:
        """The offset that it adds to the cold junction's temperature, °C."""
        return _signed(self.registers[CJTO : CJTO + 1]) / 16

    def may_write(self, place: int) -> bool:
        """Return whether a register is writable."""
        return place <= CJTO or (place in {CJTH, CJTL} and not self.measures_junction)

    @cached_property
    def first_s(self) -> float:
        """Longest time of the first conversion after a stop, s."""
        return self._conversion_s(FIRST_S)

    @cached_property
    def next_s(self) -> float:
        """Longest time of the following conversions, s."""
        return self._conversion_s(NEXT_S)

    @cached_property
    def test_s(self) -> float:
        """Time that the test for an open thermocouple adds, s."""
        return TEST_S[self.registers[CR0] & TESTS_OPEN]

    def _conversion_s(self, times: Mapping[float, tuple[float, float]]) -> float:
        alone_s, each_s = times[self.mains_hz]
        return alone_s + (self.samples - 1) * each_s


def junction_c(registers: bytes | bytearray) -> float:
    """Return the cold junction's temperature in the registers, °C."""
    return (_signed(registers[CJTH : CJTL + 1]) >> 2) / 64


def threshold_bits(registers: bytes) -> int:
    """Return the bits of SR for temperatures beyond their thresholds."""
    cold_c, code = junction_c(registers), _signed(registers[LTCBH : LTCBM + 1])
    cold_high_c, cold_low_c, high, low = _thresholds(registers[CJHF:CJTO])
    bits = CJ_HIGH * (cold_c > cold_high_c) | CJ_LOW * (cold_c < cold_low_c)
    return bits | TC_HIGH * (code > high) | TC_LOW * (code < low)


@lru_cache(maxsize=64)
def _thresholds(registers: bytes) -> tuple[int, int, int, int]:
    """Return the highest and lowest cold junction, °C, and the highest and lowest code."""
    edges = (0, CJLF - CJHF, LTHFTH - CJHF, LTLFTH - CJHF, len(registers))
    cold_high_c, cold_low_c, high, low = (_signed(registers[a:b]) for a, b in pairwise(edges))
    return cold_high_c, cold_low_c, high, low


def _signed(register: bytes | bytearray) -> int:
    return int.from_bytes(register, "big", signed=True)
