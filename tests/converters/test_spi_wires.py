"""The slave's end of the wires: what it judges, what it drives, what it does when misused."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from chip_bench import THREE_WIRES as WIRES
from chip_bench import Reader
from numpy.typing import NDArray
from rig.avr import running

from heatwright.sim.native.hw import Hw
from heatwright.sim.native.shim import load
from heatwright.sim.native.spi import PHASES, Timing, _cycles
from heatwright.sim.sensors.max6675 import LONGEST_S, TIMING, Max6675

TOO_LONG_NS = 1e6


@pytest.fixture
def reader() -> Reader:
    return Reader()


@pytest.fixture
def max6675(reader: Reader) -> Max6675:
    return Max6675(reader.avr, WIRES)


@pytest.mark.parametrize("phase", [*PHASES[:4], "hold", "idle"])
def test_a_phase_that_is_too_short_is_counted(reader: Reader, max6675: Max6675, phase: str) -> None:
    reader.read(16)
    assert max6675.port.violations == 0
    max6675.port.retime(replace(TIMING, **{phase: TOO_LONG_NS}))
    reader.read(16)
    phases = max6675.port.phases
    assert {name for name, seen in phases.items() if seen.violations} == {phase}
    once = phase in {"setup", "hold", "idle"}
    assert phases[phase].violations == (1 if once else 16 if phase == "high" else 15)


def test_phases_are_measured(reader: Reader, max6675: Max6675) -> None:
    """As the log of the pins has them."""
    select, clock = (reader.avr.pins.watch(pin) for pin in (WIRES.select, WIRES.clock))
    reader.read(16)
    reader.read(16)
    phases = max6675.port.phases
    assert set(phases) == set(PHASES) - {"told", "kept"}
    events = reader.avr.pins.take()
    down, up = edges(events, select)
    rises, falls = edges(events, clock)[::-1]
    first, last = rises[::16], falls[15::16]
    highs = falls - rises
    lows, periods = (np.delete(gaps, 15) for gaps in (rises[1:] - falls[:-1], np.diff(rises)))
    for name, cycles in (
        ("setup", first - down), ("high", highs), ("low", lows), ("period", periods),
        ("hold", up - last), ("idle", down[1:] - up[:-1]),
    ):  # fmt: skip
        assert phases[name].least == min(cycles) * 62.5
        assert phases[name].most == max(cycles) * 62.5
    assert 1000 - 4 * 62.5 < phases["read"].least < phases["read"].most < phases["low"].most


def edges(events: NDArray[Any], pin: int) -> tuple[NDArray[Any], NDArray[Any]]:
    of_pin = events[events["pin"] == pin]
    cycles = of_pin["cycle"].astype(int)
    return cycles[of_pin["state"] & 1 == 0], cycles[of_pin["state"] & 1 == 1]


def test_who_reads_too_early_reads_the_bit_before(reader: Reader, max6675: Max6675) -> None:
    max6675.sense(341.25)  # 0101 0101 0101
    reader.avr.run(LONGEST_S)
    assert reader.read(16) == 0b0010101010101001
    max6675.port.retime(replace(TIMING, output=7000))
    late = reader.read(16)
    assert late == 0b0001010101010100
    phases = max6675.port.phases
    assert phases["read"].violations == 15


def test_the_first_bit_may_be_late(reader: Reader, max6675: Max6675) -> None:
    reader.avr.pins.drive("PB4", None)
    max6675.sense(100.0)
    reader.avr.run(LONGEST_S)
    max6675.port.retime(replace(TIMING, enable=1e5))
    assert reader.read(16) == 0x8000 | 400 << 3 | 1
    assert max6675.port.phases["read"].violations == 1


def test_twenty_megahertz_can_do_exactly_100_ns() -> None:
    """Two cycles of 50 ns; a rounding error must not ask for three."""
    shim = load()
    for clock_hz, cycles in ((20_000_000, 2), (16_000_000, 2), (8_000_000, 1), (10_000_000, 1)):
        timing = _cycles(Hw(shim.lib, shim.ffi, None, clock_hz), Timing())
        assert timing.high == cycles


def test_a_processor_that_drives_the_data_line_fights() -> None:
    avr = running(
        """int main(void) {
            PORTB = _BV(PB2); DDRB = _BV(PB2) | _BV(PB0);
            _delay_ms(250);
            PORTB |= _BV(PB4); DDRB |= _BV(PB4);
            PORTB &= ~_BV(PB2);
            _delay_us(2);
            (void)PINB;
            for (;;) {}
        }"""
    )
    chip = Max6675(avr, WIRES)
    avr.run(0.26)
    assert chip.reads == 1
    assert avr.pins.contention_cycles("PB4") > 0.005 * avr.clock_hz


def test_what_a_chip_raises_comes_out_of_the_run(reader: Reader) -> None:
    class Broken:
        def selected(self, cycle: int) -> None:
            raise RuntimeError(f"broken when selected {cycle > 0}")

        def released(self, cycle: int) -> None:
            raise RuntimeError(f"broken when released {cycle > 0}")

    reader.avr.spi(WIRES, Broken())
    with pytest.raises(RuntimeError, match="broken when selected True"):
        reader.read(16)


def test_too_many_chips(reader: Reader) -> None:
    for _ in range(8):
        Max6675(reader.avr, WIRES)
    with pytest.raises(ValueError, match="too many SPI chips"):
        Max6675(reader.avr, WIRES)
