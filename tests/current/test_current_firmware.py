"""From the current in a wire to what the firmware takes it for, in the binary."""

from collections.abc import Iterator

import numpy as np
import pytest
from current_board import CIRCUITS, Measured, controller_of, program
from whole_firmware import Broken

from heatwright.sim.chain import chain_errors
from heatwright.sim.circuits import Wiring
from heatwright.sim.elf import Elf
from heatwright.sim.reference.current import IdealSensor

SAFE_A = 3.9
"""Below what trips."""


@pytest.mark.parametrize("circuit", CIRCUITS)
def test_the_chain_is_exact_to_one_step(circuit: str) -> None:
    (found,) = chain_errors(controller_of(circuit), program(circuit))
    assert found.passed
    assert found.measures == "current"
    assert found.chain_steps <= 0.5 + 1e-3  # a line has no error of its own
    assert found.as_json()["rows"][0]["current"] == 0.0


@pytest.mark.parametrize("circuit", CIRCUITS)
def test_it_reads_what_flows(circuit: str) -> None:
    bench = Measured(circuit)
    ideal = IdealSensor(bench.sensor, bench.controller.board)
    for amperes in (0.0, 1.0, 0.013, SAFE_A, 2.5, 0.0):
        bench.step(amperes)
        assert bench.raw == ideal.read(amperes)[1]
        assert np.float32(bench.amperes) == bench.law(bench.raw)
        assert bench.amperes == pytest.approx(amperes, abs=0.5001 * bench.law.step_a)


def test_a_reading_is_of_the_last_moments_before_the_step() -> None:
    """Four codes, 40 ms: what flowed until 60 ms before the step is forgotten."""
    bench = Measured("shunt")
    bench.step(3.0)
    bench.run_on(0.92)
    bench.device.sense("amps", 1.0)
    bench.step(1.0)
    assert bench.amperes == pytest.approx(1.0, abs=bench.law.step_a)


def test_a_reading_is_all_that_there_is_time_for() -> None:
    """Of 32 codes a current that flows for the last 80 ms has eight, or seven."""
    bench = Measured("most")
    bench.step(0.0)
    bench.run_on(0.90)
    bench.device.sense("amps", 3.2)
    bench.step(3.2)
    assert 7 * 0.1 <= bench.amperes <= 11 * 0.1


def test_a_current_below_the_scale_is_none() -> None:
    bench = Measured("hall")
    bench.step(-1.0)
    assert bench.raw < 16 * 512
    assert bench.amperes == 0.0


def test_an_adc_that_hangs_leaves_the_last_current() -> None:
    bench = Measured("shunt")
    bench.step(1.0)
    before = bench.raw
    bench.device.avr.adc.fail(hung=True)
    bench.step(3.0)
    assert bench.raw == before
    bench.device.avr.adc.fail()
    bench.step(3.0)
    assert bench.amperes == pytest.approx(3.0, abs=bench.law.step_a)


def test_a_wire_that_is_torn_reads_nothing_and_a_short_everything() -> None:
    bench = Measured("shunt")
    bench.step(1.0)
    bench.probe.wiring = Wiring(opened=True)
    bench.step(1.0)
    assert bench.raw == 0
    bench.probe.wiring = Wiring(pin="high")
    bench.step(1.0)
    assert bench.raw == 4 * 1023


def test_a_line_that_is_off_is_found() -> None:
    elf = Elf(program("shunt").path)
    at = elf.symbols["sensor_amps_line"]
    worse = np.array([1.0], "<f4").tobytes()
    elf.flash = elf.flash[:at] + worse + elf.flash[at + 4 :]
    (found,) = chain_errors(controller_of("shunt"), elf)
    assert not found.passed


MUTANTS = [
    Broken("sensor_amps.c", right, wrong)
    for right, wrong in (
        ("ticks_left = SENSOR_AMPS_START_TICKS;", "ticks_left = 0;"),
        ("    codes_taken = 0;\n", ""),
        ("    sum = 0;\n", ""),
        ("        ticks_left--;\n", "        ticks_left = 0;\n"),
        ("codes_taken == SENSOR_AMPS_OVERSAMPLE || ", "false || "),
        ("|| !adc_is_fresh()", ""),
        ("sum + adc_code(", "sum + 1u + adc_code("),
        ("    codes_taken++;\n", ""),
        ("if (codes_taken != SENSOR_AMPS_OVERSAMPLE)", "if (false)"),
        ("    *raw = (int16_t)sum;\n", ""),
    )
] + [
    Broken("amperes_amps.c", right, wrong)
    for right, wrong in (
        ("(float)raw * pgm", "pgm"),
        ("        + pgm", "        - pgm"),
        ("amperes < 0.0f ? 0.0f : amperes", "amperes"),
        ("_line.amperes_per_count", "_line.amperes_at_zero"),
    )
]  # fmt: skip


def complaints(broken: Broken | None) -> Iterator[str]:
    """Say what is wrong with a firmware."""
    bench = Measured("hall", broken)
    ideal = IdealSensor(bench.sensor, bench.controller.board)
    for amperes in (0.0, 1.0, SAFE_A, 2.0):
        bench.step(amperes)
        if bench.raw != ideal.read(amperes)[1] or np.float32(bench.amperes) != bench.law(bench.raw):
            yield f"{amperes} A are {bench.amperes} A"
    bench.step(-1.0)
    if bench.amperes != 0.0:
        yield "negative"
    bench.step(3.0)
    bench.run_on(0.8)  # of 16 codes, all come later
    bench.step(1.0)
    if bench.raw != ideal.read(1.0)[1]:
        yield "too early"
    before = bench.raw
    bench.device.sense("amps", 3.0)
    bench.run_on(0.9)  # some codes have been taken
    bench.device.avr.adc.fail(hung=True)
    bench.step(3.0)
    if bench.raw != before:
        yield "a reading of missing codes"


def test_nothing_is_wrong_with_it_whole() -> None:
    assert not list(complaints(None))


@pytest.mark.parametrize("broken", MUTANTS, ids=lambda each: f"{each.file}: {each.right[:40]}")
def test_a_broken_line_is_seen(broken: Broken) -> None:
    assert any(complaints(broken))
