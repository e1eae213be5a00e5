"""The sensor on the simulated processor: what its firmware makes of each answer, and its wires."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import pytest
from heatwright_max31865.model import POLYNOMIAL_K
from heatwright_max31865.reference import converter, ratio_of
from heatwright_max31865.simulated import FORGET, LARGEST, resistance_ratio

from heatwright.cli.contract import lacking
from heatwright.generator import plan_firmware, render, write
from heatwright.generator.toolchain import build
from heatwright.sim.device import AvrDevice
from heatwright.spec import BOARDS, RULES, Controller, SpecError, load_text

EXAMPLE = (files("heatwright_max31865") / "example.yaml").read_text(encoding="utf-8")
FAR = {"uno": "mega2560", "D10": "D49", "D13": "A8", "D11": "D48", "D12": "D17"}
"""Pins beyond the reach of `sbi`."""
BOARDS_TRIED = {
    "16 MHz": EXAMPLE,
    "20 MHz": EXAMPLE.replace("board: uno", "board: uno\n  clock: 20 MHz"),
    "8 MHz": EXAMPLE.replace("board: uno", "board: uno\n  clock: 8 MHz"),
    "far": EXAMPLE,
}
for near, far in FAR.items():
    BOARDS_TRIED["far"] = BOARDS_TRIED["far"].replace(near, far)
PERIOD_S, AFTER_S = 0.25, 0.02


@cache
def built(text: str) -> tuple[Controller, Path]:
    spec = load_text(text)
    project = Path(mkdtemp())
    write(render(plan_firmware(spec)), project)
    return spec.controller, build(project).elf


class Bench:
    """The example's board; chip -- its converter."""

    def __init__(self, text: str = EXAMPLE) -> None:
        self.device = AvrDevice(*built(text))
        self.chip: Any = self.device.sensors["air"]
        self.sense(50.0)
        self.device.advance(4 * PERIOD_S + AFTER_S)

    def sense(self, temperature_c: float) -> None:
        self.device.sense("air", temperature_c)

    def step(self, count: int = 1) -> tuple[str, float]:
        """Run so many steps; return what the last one says of its reading, and the temperature."""
        self.device.advance(self.device.time_s + count * PERIOD_S)
        last = self.device.steps("air")[-1]
        status = int(last["reading_status"])
        return RULES[status].id if status else "ok", float(last["temperature_c"])


def test_nothing_is_missing() -> None:
    assert list(lacking("sensor", "max31865")) == []


def test_the_polynomial_is_that_of_the_norm() -> None:
    controller, _ = built(EXAMPLE)
    sensor: Any = controller.sensors["air"]
    convert = converter(sensor, BOARDS["uno"])
    per_code = sensor.reference_ohm / sensor.ohm_at_0 / (LARGEST + 1)
    step = 0
    for tenths in range(-2000, 8500, 7):
        temperature_c = tenths / 10
        code = round(ratio_of(temperature_c) / per_code)
        half_a_step_k = sensor.step_at_k(temperature_c, "") / 2
        assert abs(convert(code) - temperature_c) <= POLYNOMIAL_K + half_a_step_k
        assert code > step
        step = code
    assert ratio_of(-200.0) == pytest.approx(0.18520, abs=5e-6)  # the norm's table, in 100 Ω
    assert ratio_of(850.0) == pytest.approx(3.90481, abs=5e-6)
    assert resistance_ratio(-123.4) == pytest.approx(ratio_of(-123.4))


@pytest.mark.parametrize("name", BOARDS_TRIED)
def test_the_wires_keep_to_the_data_sheet(name: str) -> None:
    bench = Bench(BOARDS_TRIED[name])
    assert bench.step(8)[0] == "ok"
    assert set(bench.chip.violations.values()) == {0}, bench.chip.port.phases
    assert bench.chip.misused == 0


@pytest.mark.parametrize("felt_c", [-199.0, -40.0, 0.0, 25.0, 200.0, 849.0])
def test_it_reads_what_it_feels(felt_c: float) -> None:
    bench = Bench()
    bench.sense(felt_c)
    status, read_c = bench.step(2)
    assert (status, read_c) == ("ok", pytest.approx(felt_c, abs=0.05))


@pytest.mark.parametrize(
    ("what", "rule"),
    [
        (lambda chip: setattr(chip.faults, "open", True), "sensor_open"),
        (lambda chip: setattr(chip, "shorted", True), "sensor_short"),
        (lambda chip: setattr(chip, "beyond_supply", True), "sensor_short"),
        (lambda chip: chip.tip.tell(900.0), "sensor_range"),
        (lambda chip: chip.unplug(), "sensor_no_answer"),
        (lambda chip: chip.short("low"), "sensor_short"),
        (lambda chip: chip.short("high"), "sensor_no_answer"),
        (lambda chip: setattr(chip.faults, "dumb", True), "sensor_no_answer"),
        (lambda chip: setattr(chip.faults, "corrupt_next", 1), "sensor_crc"),
        (lambda chip: chip.brown_out(), "sensor_reset"),
    ],
)
def test_what_is_wrong_is_told(what: Any, rule: str) -> None:
    bench = Bench()
    what(bench.chip)
    told = [bench.step()[0] for _ in range(3)]
    assert rule in told[:2], told


def test_it_reads_again_when_all_is_well() -> None:
    bench = Bench()
    bench.chip.faults.open = True
    assert bench.step(2)[0] == "sensor_open"
    bench.chip.settle()
    bench.chip.faults.open = False
    assert bench.step(3)[0] == "ok"
    assert not bench.chip._registers[0] & FORGET


@pytest.mark.parametrize(
    ("was", "told", "message"),
    [
        ("430 Ω", "4300 Ω", "a reference of 4300 Ω does not fit a pt100"),
        ("wires: 3", "wires: 5", "a number of wires must be a whole number from 2 to 4"),
        ("data_in: D11", "", "this key is missing"),
        ("D11", "D12", "D12"),
    ],
)
def test_a_bad_spec_is_refused(was: str, told: str, message: str) -> None:
    with pytest.raises(SpecError, match=message):
        load_text(EXAMPLE.replace(was, told, 1))
