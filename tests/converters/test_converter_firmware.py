"""The firmware's reader on several boards and crystals, and what it makes of any answer."""

from random import Random

import numpy as np
import pytest
from converter_checks import (
    ANSWERS,
    CRC,
    NO_ANSWER,
    OPEN,
    SHORT,
    SHORTEST_S,
    STALE,
    VALID,
    answers_problem,
    reading_problem,
    short_problem,
    words,
)
from rig.chips import KINDS, PINS, Crucible, crucible
from rig.specs import files_of

from heatwright.sim.replay import replay

SPEED = [("uno", ""), ("leonardo", ""), ("mega2560", ""), ("atmega1284p", ""),
         ("atmega1284p", ", clock: 20 MHz"), ("atmega1284p", ", clock: 8 MHz")]  # fmt: skip
MOST_US = 100.0
MOST_MASKED_US = 20.0

of_all = pytest.mark.parametrize("kind", KINDS)
of_both = pytest.mark.parametrize("kind", ANSWERS)


@of_all
@pytest.mark.parametrize(("board", "clock"), SPEED)
def test_it_keeps_to_the_data_sheet_and_reads_in_time(kind: str, board: str, clock: str) -> None:
    bench = Crucible(crucible(kind, board, clock=clock))
    profile = bench.device.avr.profile(bench.device.elf)
    assert bench.statuses(10) == [VALID] * 10
    chip = bench.chip
    assert chip.reads == 10
    assert chip.port.violations == 0
    phases = {"setup", "high", "low", "period", "read", "hold", "idle"}
    if kind == "max31856":
        phases |= {"told", "kept"}
        assert (chip.orders, chip.misused) == (2, 0)
    assert set(chip.port.phases) == phases
    us = 1e6 / bench.device.avr.clock_hz
    assert profile.functions["sensor_tip_tick"].longest * us < MOST_US
    wires = [each for name, each in profile.functions.items() if name.startswith("spi_tip")]
    assert max(each.masked for each in wires) * us < MOST_MASKED_US


@of_all
@pytest.mark.parametrize("board", PINS)
def test_temperatures_over_its_range(kind: str, board: str) -> None:
    bench = Crucible(crucible(kind, board))
    assert reading_problem(bench, 60) == ""


@of_both
def test_any_answer(kind: str) -> None:
    judged, bits, often_zero = ANSWERS[kind]
    drawn = words(Random(7), bits, often_zero, 60)  # noqa: S311 - no secret
    assert answers_problem(Crucible(crucible(kind)), drawn, judged) == ""
    seen = {judged(word)[0] for word in drawn}
    assert seen == ({VALID, NO_ANSWER, CRC, OPEN} | ({SHORT} if kind == "max31855" else set()))


WIRED = {
    ("data", "low"): SHORT,
    ("data", "high"): NO_ANSWER,
    ("select", "high"): NO_ANSWER,  # as a broken wire with a pull-up at the chip
    ("clock", "low"): NO_ANSWER,  # the first bit is 0, and no other comes
}
WITH_REGISTERS = {
    ("clock", "high"): NO_ANSWER,
    ("told", "low"): VALID,  # every answer begins with the first register: it asks for that
    ("told", "high"): NO_ANSWER,
}
"""What a broken or shorted wire reads; which of them look alike."""


@pytest.mark.parametrize(
    ("kind", "wire", "due"),
    [
        (kind, *each)
        for kind in KINDS
        for each in (WIRED | (WITH_REGISTERS if kind == "max31856" else {})).items()
    ],
)
def test_each_wire(kind: str, wire: tuple[str, str], due: int) -> None:
    bench = Crucible(crucible(kind))
    bench.sense(100.0)
    assert bench.statuses(3)[1:] == [VALID] * 2
    name, level = wire
    pin = getattr(bench.chip._wires, name)
    bench.device.avr.pins.drive(pin, level)  # type: ignore[arg-type]
    found = bench.statuses(2)
    assert found[-1] == due
    assert kind == "max31856" or found[0] == due
    bench.device.avr.pins.drive(pin, None)
    assert bench.statuses(3)[-1] == VALID


@of_both
def test_a_select_that_is_held_low_is_a_short(kind: str) -> None:
    """The chip then never lets go of the data line, whose first bit is 0."""
    bench = Crucible(crucible(kind))
    bench.sense(100.0)
    bench.steps(3)
    bench.device.avr.pins.drive("PB2", "low")
    bench.device.avr.run(0.001)
    assert bench.statuses(2) == [SHORT] * 2


@of_all
def test_a_short_of_its_answers_and_a_chip_that_is_not_there(kind: str) -> None:
    period_s = SHORTEST_S if kind == "max31856" else 0
    assert short_problem(Crucible(crucible(kind, period_s=period_s))) == ""


@pytest.mark.parametrize(("kind", "period_s"), [("max6675", 0.23), ("max31855", 0.2)])
def test_the_shortest_period(kind: str, period_s: float) -> None:
    """A reading in every step from the first that can have one; conversions come to their end."""
    bench = Crucible(crucible(kind, period_s=period_s))
    device = bench.device
    for turn in range(20):
        bench.sense(100.0 + turn)
        device.advance((turn + 1) * period_s + 0.01)
    steps = device.steps("crucible")
    late = 0 if kind == "max6675" else 1
    assert steps["reading_status"].tolist() == [STALE] * late + [VALID] * (20 - late)
    wanted = [4 * (100 + max(turn - 1, 0)) for turn in range(20)]
    assert (abs(steps["reading_raw"] - np.array(wanted))[2:] <= 4).all()


@of_both
def test_a_reset_of_the_processor_alone(kind: str) -> None:
    """The chip goes on; the program waits for it as after power-up."""
    bench = Crucible(crucible(kind))
    bench.sense(100.0)
    bench.steps(4)
    bench.device.avr.reset("external")
    assert bench.statuses(4)[-1] == VALID


@of_all
def test_replay(kind: str) -> None:
    """Valid readings, lost ones, faults: every member as the reference has it."""
    bench = Crucible(crucible(kind))
    for turn in range(60):
        bench.sense(20.0 + turn + 0.13 * turn % 3)
        bench.chip.faults.corrupt_next = turn % 5 == 0
        bench.steps()
    bench.chip.faults.open = True
    bench.steps(22)
    steps = bench.device.steps("crucible")
    assert OPEN in steps["fault.code"]
    result = replay(bench.controller, steps)
    assert (result.ticks, result.mismatches, result.unchecked) == (len(steps), 0, ("fault.time_s",))


@of_both
def test_the_readme_says_how_to_wire_it(kind: str) -> None:
    """Without these a broken thermocouple is not seen, or a good one is taken for a short."""
    text = files_of(crucible(kind))["README.md"]
    rows = [line for line in text.splitlines() if "sensor `tip`" in line]
    assert [row.split(" = ")[0] for row in rows[:3]] == ["| D10", "| D8", "| D12"]
    wanted = {"max6675": "T- to its ground", "max31855": "must not touch ground"}
    assert wanted[kind] in rows[3]
    assert ("level shifter" in rows[0]) == (kind == "max31855")
