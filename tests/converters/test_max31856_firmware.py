"""What the firmware sets a MAX31856 up to, what its answers are to it, and when it starts anew."""

import numpy as np
import pytest
from converter_checks import (
    CJTO,
    CRC,
    NO_ANSWER,
    OPEN,
    RANGE,
    RESET,
    SETTINGS,
    SHORT,
    SHORTEST_S,
    VALID,
    judged_31856,
    registers_problem,
    registers_said,
    set_up_problem,
)
from rig.chips import Crucible, crucible


@pytest.fixture
def bench() -> Crucible:
    return Crucible(crucible("max31856"))


@pytest.fixture
def brisk() -> Crucible:
    return Crucible(crucible("max31856", period_s=SHORTEST_S))


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


def test_it_is_set_up_whatever_it_was_told_before(brisk: Crucible) -> None:
    assert set_up_problem(brisk) == ""


def test_any_answer(brisk: Crucible) -> None:
    """Settings that are not as they were written are written again: then it must read once more."""
    answers = registers_said(60)
    assert registers_problem(brisk, answers) == ""
    seen = {judged_31856(answer)[0] for answer in answers}
    assert seen == {VALID, NO_ANSWER, SHORT, CRC, RESET, OPEN, RANGE}


def test_never_told_it_never_converts(bench: Crucible) -> None:
    """Its input is at ground from the start: it keeps the settings of its power-up."""
    bench.chip.short_orders("low")
    bench.steps()
    bench.chip.brown_out()
    assert set(bench.statuses(6)[1:]) == {RESET}


def test_an_interrupted_supply_costs_one_reading(bench: Crucible) -> None:
    bench.steps(3)
    bench.chip.brown_out()
    assert bench.statuses(4) == [RESET, VALID, VALID, VALID]
    assert bench.chip._registers[: CJTO + 1] == SETTINGS


@pytest.mark.parametrize("early_s", np.arange(0.0, 0.08, 0.01))
def test_a_reset_of_the_controller_in_the_middle_of_an_answer(
    bench: Crucible, early_s: float
) -> None:
    """The chip goes on, selected or not; it is set up anew, and no reading is wrong."""
    device = bench.device
    bench.sense(77.0)
    device.advance(4 * bench.period_s - early_s + 0.0005)
    device.avr.reset()
    device.advance(device.time_s + 4 * bench.period_s)
    log = device.steps("crucible")
    good = log["reading_raw"][log["reading_status"] == VALID]
    assert set(good.tolist()) <= {20 * 128, 77 * 128}
    assert bench.chip.misused == 0
