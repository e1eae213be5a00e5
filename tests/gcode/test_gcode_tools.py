"""Several tools on one line, and loops without gains."""

import re
from pathlib import Path

import pytest

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.toolchain import build
from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.spec import load_text

CURVE = "divider: {pull_up: 4.7 kΩ}, curve: {resistance: 100 kΩ, at: 25 °C, beta: 4267 K}"
SPEC = f"""heatwright: 1
controller: {{name: pair, board: uno}}
sensors:
  nozzle: {{kind: thermistor, pin: A0, {CURVE}, range: 0 °C .. 300 °C}}
  bed: {{kind: thermistor, pin: A1, {CURVE}, range: 0 °C .. 300 °C}}
outputs:
  nozzle: {{kind: pwm, pin: D9, frequency: 100 Hz, power: 40 W}}
  bed: {{kind: digital, pin: D4, power: 100 W}}
loops:
  nozzle:
    sensor: nozzle
    heater: nozzle
    period: 100 ms
    setpoint: {{initial: 0 °C, minimum: 10 °C, maximum: 250 °C}}
    algorithm: {{kind: pid, kp: 5, ki: 0.1, kd: 10}}
    autotune: {{}}
    protection: {{maximum: 280 °C, minimum: 5 °C, rise_rate: 20 K/s}}
  bed:
    sensor: bed
    heater: bed
    period: 500 ms
    setpoint: {{initial: 0 °C, minimum: 10 °C, maximum: 110 °C}}
    algorithm: {{kind: on_off}}
    protection: {{maximum: 130 °C, minimum: 5 °C}}
interfaces:
  - {{kind: gcode, baud: 57600, loops: {{T1: nozzle, T3: bed}}}}
"""


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> AvrDevice:
    spec = load_text(SPEC, "pair.yaml")
    folder = tmp_path_factory.mktemp("pair")
    write(render(plan_firmware(spec)), folder)
    device = AvrDevice(spec.controller, Elf(build(Path(folder)).elf))
    device.sense("nozzle", 30.0)
    device.sense("bed", 20.0)
    device.advance(2.0)
    return device


def told(device: AvrDevice, *lines: str) -> list[str]:
    host = device.host
    known = len(host.lines)
    host.numbers = False
    for line in lines:
        device.send(line)
    device.advance(device.time_s + 3.0)
    return [each.text for each in device.host.lines[known:]]


def whole_degrees(answers: list[str]) -> list[str]:
    """The readings are as fine as the converter."""
    return [re.sub(r"(T\d?:\d+)\.\d", r"\1", answer) for answer in answers]


def test_the_first_number_is_the_active_one_until_another_is_told(board: AvrDevice) -> None:
    assert whole_degrees(told(board, "M105")) == [
        "ok T:30 /0.0 B:0.0 /0.0 T1:30 /0.0 T3:20 /0.0 @:0 @1:0 @3:0"
    ]
    told(board, "M104 S15", "M104 T3 S12", "T3")
    assert whole_degrees(told(board, "M105")) == [
        "ok T:20 /12.0 B:0.0 /0.0 T1:30 /15.0 T3:20 /12.0 @:0 @1:0 @3:0"
    ]
    told(board, "M104 S0", "T1", "M104 S0")
    assert whole_degrees(told(board, "M105")) == [
        "ok T:30 /0.0 B:0.0 /0.0 T1:30 /0.0 T3:20 /0.0 @:0 @1:0 @3:0"
    ]


@pytest.mark.parametrize("tool", [0, 2, 4, 255])
def test_other_numbers_are_not_there(board: AvrDevice, tool: int) -> None:
    assert told(board, f"M104 T{tool} S50") == [f"echo:M104 Invalid extruder {tool}", "ok"]
    assert told(board, f"T{tool}") == [f'echo:Unknown command: "T{tool}"', "ok"]


def test_each_has_its_own_limits(board: AvrDevice) -> None:
    beyond = "Error:M104 is outside its limits; nothing was changed"
    assert told(board, "M104 T3 S111", "M104 T1 S251") == [beyond, "ok", beyond, "ok"]


def test_gains_are_those_of_the_tool_that_has_some(board: AvrDevice) -> None:
    assert told(board, "M301 T1 P6", "M503") == [
        "echo:  M301 E1 P6.00000 I0.10000 D10.00000", "ok",
        "echo:  M301 E1 P6.00000 I0.10000 D10.00000", "ok",
    ]  # fmt: skip
    unable = "refused: this tool has no such control"
    assert told(board, "M301 T3 P6", "M303 T3 S50", "M104 T3 D20") == [
        f"Error:M301 {unable}", "ok", f"Error:M303 {unable}", "ok", f"Error:M104 {unable}", "ok"
    ]  # fmt: skip


def test_there_is_no_fan_and_no_feed(board: AvrDevice) -> None:
    unknown = ["M106", "M107", "G1", "G92", "M82", "M410", "M84", "M400"]
    answers = told(board, *(f"{line} E1" for line in unknown))
    assert answers == [
        part for line in unknown for part in (f'echo:Unknown command: "{line}"', "ok")
    ]
