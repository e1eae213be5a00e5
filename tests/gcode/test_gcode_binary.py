"""The binary behind its serial line: nothing that arrives costs a tick, a byte or a limit; and
docs/gcode.md tells of every command of the firmware, and of none that there is not."""

import random
import re
from types import SimpleNamespace

import numpy as np
import pytest
from gcode_world import BinaryBoard
from printrun.utils import parse_temperature_report
from rig.firmware import ROOT, example

from heatwright.sim.faults.controller.processor import INTERRUPTS_OFF, INTERRUPTS_ON, hang
from heatwright.sim.replay import replay
from heatwright.spec.rules import RULES

BAUD = 115200
TICK_S = 0.01
FEEDER = example("feeder").controller
STEPS_PER_MM, SPEED_MM_PER_S = 128, 20


@pytest.fixture
def board() -> BinaryBoard:
    return BinaryBoard("extruder", nozzle=20.0)


def test_a_host_that_waits_for_each_ok_is_answered_within_three_ticks(board: BinaryBoard) -> None:
    """Wherever in a tick it asks: what has just missed one waits for the next."""
    for part in range(10):
        board.wait(0.1 + part * TICK_S / 10 - board.device.time_s % TICK_S)
        sent_s = board.device.time_s + 5 * 10 / BAUD
        board.tell("M105")
        answer = board.host.lines[-1]
        bytes_s = 10 / BAUD * (len(answer.text) + 1)
        assert answer.time_s < sent_s + 3 * TICK_S + bytes_s


FLOODS = {
    "M105": b"M105\n", "M503": b"M503\nM115\n", "empty": b"\n", "zeros": b"\x00", "endless": b"x",
    "resends": b"N1 M104 S200*1\n",
    "noise": random.Random(1).randbytes(100_000),  # noqa: S311 - the same in every run
}  # fmt: skip


@pytest.mark.parametrize("name", FLOODS)
def test_a_flood_costs_no_step(board: BinaryBoard, name: str) -> None:
    """Every step comes within a tick of its time, and none is left out."""
    flood = FLOODS[name]
    board.host.send_bytes(flood * (100_000 // len(flood)))
    board.wait(9.0)
    assert board.device.avr.uarts[0].overruns == 0
    assert board.device.read("fault.code") == 0
    log = board.device.steps("nozzle")
    due_s = log["time_s"][0] + 0.1 * (log["steps"] - log["steps"][0]).astype(float)
    assert np.all(np.diff(log["steps"].astype(int)) == 1)
    assert np.abs(log["time_s"] - due_s).max() < TICK_S
    board.wait(2.0)
    assert board.told("\nM105")[-1].startswith("ok T:")


def test_monitors_are_told_behind_all_that_hosts_look_for() -> None:
    """By their names; 0.0 before the first reading, as of a tool."""
    printer = BinaryBoard("printer", nozzle=20.0, plate=20.0, electronics=45.0)
    (told,) = printer.told("M105")
    head, number = told.rsplit(":", 1)
    assert re.fullmatch(r"ok T:\d+\.\d /0\.0 B:\d+\.\d /0\.0 @:0 B@:0 drivers", head)
    assert float(number) == pytest.approx(45.0, abs=0.2)
    assert parse_temperature_report(told).keys() == {"T", "B"}
    printer.sense("electronics", 70.0)
    printer.wait(3.0)
    assert "echo:warning, too warm: drivers at " in " ".join(printer.heard())
    assert parse_temperature_report(printer.told("M105")[-1]).keys() == {"T", "B"}


def test_no_rest_of_a_period_is_heated_after_an_acknowledgement(board: BinaryBoard) -> None:
    """M112 and M999 between two steps: the duty of the step before must not come back."""
    board.tell("M104 S200", 5.0)
    read = board.device.read
    steps = read("loop_nozzle.steps")
    while read("loop_nozzle.steps") == steps:
        board.wait(0.001)
    board.tell("M112", 3 * TICK_S)
    board.device.on_fraction("heater")
    board.tell("M999", 4 * TICK_S)
    assert read("fault.code") == 0
    assert read("loop_nozzle.steps") == steps + 1
    assert board.device.on_fraction("heater") == 0.0
    assert board.on_fraction("heater", 5.0) == 0.0
    assert " /0.0 B" in board.told("M105")[0]
    board.tell("M104 S200")
    assert board.device.on_fraction("heater") > 0.0


HOST_LOST_S = 600.0  # after which a silent host is lost, where the spec does not say


def test_a_silent_host_does_not_leave_a_heater_on(board: BinaryBoard) -> None:
    """From the last good line on; a line that is none, and what the firmware says, are no host."""
    board.sense("nozzle", 200.2)
    board.wait(20.0)
    for line in ("M999", "M155 S5", "M104 S200"):
        board.tell(line)
    last_s = board.device.time_s
    board.wait(300.0)
    board.tell("login:")
    board.wait(last_s + HOST_LOST_S - 1.0 - board.device.time_s)
    assert board.device.read("fault.code") == 0
    board.wait(1.5)
    assert RULES[int(board.device.read("fault.code"))].id == "master_lost"
    assert board.on_fraction("heater") == 0.0
    assert any(line.startswith("Error:E23 MASTER LOST (at ") for line in board.lines())
    assert replay(example("extruder").controller, board.device.steps("nozzle")).mismatches == 0


NARROW = (24.0, 40.0, 30.0)  # Integral's least and most, and output's most, %
WITHIN_S, PERIOD_S = 20.0, 0.1  # in which full power must show, and the loop's period


def limits_of(board: BinaryBoard) -> tuple[float, ...]:
    names = ("integral_minimum", "integral_maximum", "output_maximum")
    return tuple(float(board.device.read(f"settings.nozzle_{name}_percent")) for name in names)


def test_limits_that_a_host_sets_are_in_force_and_kept(board: BinaryBoard) -> None:
    """And a dead heater is found at what they leave as soon as at full power."""
    given = limits_of(board)
    board.tell("M301 J24 K40 Y30")
    board.tell("M104 S200", WITHIN_S - 1)
    assert (limits_of(board), board.device.read("fault.code")) == (NARROW, 0)
    assert board.on_fraction("heater", 0.5) == pytest.approx(0.3, abs=1e-3)
    board.wait(1.0)
    log = board.device.steps("nozzle")
    assert board.device.read("fault.code") == 10
    heated = np.flatnonzero(log["duty_percent"] == NARROW[2])
    assert len(heated) == round(WITHIN_S / PERIOD_S)
    result = replay(example("extruder").controller, log)
    assert (result.mismatches, result.restored) == (0, ())
    for kept, wanted in ((False, given), (True, NARROW)):
        board.tell("M301 J24 K40 Y30")
        board.tell("M500" if kept else "M105", 2.0)
        board.device.power_cycle()
        board.wait(1.0)
        assert limits_of(board) == wanted
    board.tell("M502")
    assert limits_of(board) == given
    board.tell("M501")
    assert limits_of(board) == NARROW


@pytest.mark.parametrize("entry", [INTERRUPTS_ON, INTERRUPTS_OFF])
def test_a_main_loop_that_hangs_ends_the_feed(entry: str) -> None:
    """The gate's permit lasts ten ticks; then the watchdog resets the chip."""
    board = BinaryBoard("feeder", nozzle=210.0)
    for line in ("M104 S210", "M83", f"G1 E200 F{60 * SPEED_MM_PER_S}"):
        board.tell(line)
    board.wait(3.5)
    before, feed = board.steps, board.device.outputs["feed"]
    assert before > SPEED_MM_PER_S * STEPS_PER_MM
    world = SimpleNamespace(device=board.device, site=SimpleNamespace(controller=FEEDER))
    hang(world, entry)  # type: ignore[arg-type]
    board.wait(0.5)
    assert board.steps - before <= (0.1 + 2 * TICK_S) * SPEED_MM_PER_S * STEPS_PER_MM
    assert feed.on == (entry == INTERRUPTS_OFF)
    board.wait(3.5)
    assert RULES[int(board.device.read("fault.code"))].id == "watchdog_reset"
    board.device.feed()
    assert not feed.on


def test_every_command_is_told_and_no_other() -> None:
    page = (ROOT / "docs" / "gcode.md").read_text("utf-8")
    table = page.partition("## Commands")[2].partition("\n`G0` to")[0]
    rows = re.findall(r"^\| (`[^|]+`[^|]*)\|", table, re.MULTILINE)
    text = (ROOT / "templates" / "interfaces" / "gcode" / "gcode.c.j2").read_text("utf-8")
    found = set()
    for name, letter in {"do_g": "G", "do_m": "M", "do_gains": "M", "do_feed": "M"}.items():
        body = text.partition(f"static bool {name}(void)\n")[2].partition("\n}\n")[0]
        found |= {f"{letter}{number}" for number in re.findall(r"case (\d+):", body)}
    assert set(re.findall(r"\b[GM]\d+\b", "".join(rows))) == found
