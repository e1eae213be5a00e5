"""The firmware's reader on several boards and crystals, and what it makes of any answer."""

from random import Random

import converter_checks as checks
import numpy as np
import pytest
from converter_checks import CRC, NO_ANSWER, OPEN, RANGE, RESET, SHORT, SHORTEST_S, STALE, VALID
from rig.avr import whole
from rig.chips import KINDS, PINS, Crucible, crucible
from rig.specs import example, files_of

from heatwright.cli.chips import complaints
from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.device import AvrDevice
from heatwright.sim.metrics import metrics
from heatwright.sim.replay import replay

SPEED = [("uno", ""), ("leonardo", ""), ("mega2560", ""), ("atmega1284p", ""),
         ("atmega1284p", ", clock: 20 MHz"), ("atmega1284p", ", clock: 8 MHz")]  # fmt: skip
MOST_US = 100.0
MOST_MASKED_US = 20.0

of_all = pytest.mark.parametrize("kind", KINDS)
of_both = pytest.mark.parametrize("kind", checks.ANSWERS)


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
    assert checks.reading_problem(bench, 60) == ""


@of_both
def test_any_answer(kind: str) -> None:
    judged, bits, often_zero = checks.ANSWERS[kind]
    drawn = checks.words(Random(7), bits, often_zero, 60)  # noqa: S311 - no secret
    assert checks.answers_problem(Crucible(crucible(kind)), drawn, judged) == ""
    seen = {judged(word)[0] for word in drawn}
    assert seen == ({VALID, NO_ANSWER, CRC, OPEN} | ({SHORT} if kind == "max31855" else set()))


WIRED = {
    ("data", "low"): SHORT,
    ("data", "high"): NO_ANSWER,
    ("select", "high"): NO_ANSWER,  # as a broken wire with a pull-up at the chip
    ("clock", "low"): NO_ANSWER,  # the first bit is 0, and no other comes
}
SELECTED = {("select", "low"): SHORT}  # it never lets go of the data line, whose first bit is 0
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
        for each in (WIRED | (WITH_REGISTERS if kind == "max31856" else SELECTED)).items()
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


@of_all
def test_a_short_of_its_answers_and_a_chip_that_is_not_there(kind: str) -> None:
    period_s = SHORTEST_S if kind == "max31856" else 0
    assert checks.short_problem(Crucible(crucible(kind, period_s=period_s))) == ""


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


@pytest.fixture
def max31856() -> Crucible:
    return Crucible(crucible("max31856"))


@pytest.mark.parametrize("letter", "BEJKNRST")
@pytest.mark.parametrize(("average", "mains"), [(1, 60), (2, 50), (4, 60), (16, 50)])
def test_every_setting(letter: str, average: int, mains: int) -> None:
    extra = f", thermocouple: {letter}, average: {average}, mains_filter: {mains} Hz"
    bench = Crucible(crucible("max31856", period_s=0.35 if average == 1 else 1, extra=extra))
    celsius = 640 if letter == "B" else 240
    bench.sense(celsius)
    bench.device.advance(4.0)
    log = bench.device.steps("crucible")
    assert set(log["reading_status"][1:]) <= {VALID}
    assert log["reading_raw"][-1] == celsius * 128
    code = {1: 0, 2: 1, 4: 2, 16: 4}[average]
    settings = [0x90 | (mains == 50), code << 4 | "BEJKNRST".index(letter)]
    assert bench.chip._registers[:2] == bytes(settings)
    assert bench.chip.misused == 0


def test_a_max31856_is_set_up_and_answers_anything() -> None:
    """Settings that are not as they were written are written again: then it must read once more."""
    brisk = Crucible(crucible("max31856", period_s=SHORTEST_S))
    assert checks.set_up_problem(brisk) == ""
    answers = checks.registers_said(60)
    assert checks.registers_problem(brisk, answers) == ""
    seen = {checks.judged_31856(answer)[0] for answer in answers}
    assert seen == {VALID, NO_ANSWER, SHORT, CRC, RESET, OPEN, RANGE}


def test_never_told_it_never_converts(max31856: Crucible) -> None:
    """Its input is at ground from the start: it keeps the settings of its power-up."""
    max31856.chip.short_orders("low")
    max31856.steps()
    max31856.chip.brown_out()
    assert set(max31856.statuses(6)[1:]) == {RESET}


def test_an_interrupted_supply_costs_one_reading(max31856: Crucible) -> None:
    max31856.steps(3)
    max31856.chip.brown_out()
    assert max31856.statuses(4) == [RESET, VALID, VALID, VALID]
    assert max31856.chip._registers[: checks.CJTO + 1] == checks.SETTINGS


@of_all
@pytest.mark.parametrize("early_s", np.arange(0.0, 0.08, 0.01))
def test_a_reset_of_the_controller_in_the_middle_of_an_answer(kind: str, early_s: float) -> None:
    """The chip goes on, selected or not; it is set up anew, and no reading is wrong."""
    bench = Crucible(crucible(kind))
    device = bench.device
    bench.sense(77.0)
    device.advance(4 * bench.period_s - early_s + 0.0005)
    device.avr.reset("external")
    device.advance(device.time_s + 4 * bench.period_s)
    log, steps = device.steps("crucible"), checks.STEPS_PER_K[kind]
    good = log["reading_raw"][log["reading_status"] == VALID]
    assert set(good.tolist()) <= {20 * steps, 77 * steps}
    assert log["reading_status"][-1] == VALID
    assert kind != "max31856" or bench.chip.misused == 0


@pytest.mark.parametrize("name", ["press", "hotplate"])
def test_an_example_meets_what_is_expected(name: str) -> None:
    """Binary and model, each in closed loop."""
    controller = example(name).controller
    device, (loop,) = AvrDevice(controller, whole(name)), controller.loops
    wanted = controller.simulation.expect
    for each in (ReferenceDevice(controller), device):
        trace = bench(controller, each)
        found = metrics(trace, controller)
        assert 0 <= found.overshoot_k <= wanted.overshoot_k
        assert found.steady_error_k <= wanted.steady_k
        assert set(trace.steps[loop]["fault.code"]) == {0}
    assert complaints(device) == ()
    result = replay(controller, trace.steps[loop])
    assert (result.mismatches, set(result.unchecked)) == (0, {"fault.time_s"})
