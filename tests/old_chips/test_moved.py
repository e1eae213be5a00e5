"""The examples on an ATmega32 and an ATmega16: built by PlatformIO, run, replayed bit for bit."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner
from rig.firmware import changed, files_of

from heatwright.cli.main import cli

MOVES = {
    # A bare chip takes no shield: without keys the setpoint is what it begins with.
    "chamber": {
        "board: uno": "board: {board}", "pin: A1,": "pin: PA1,", "pin: D3,": "pin: PC0,",
        "pin: D11,": "pin: PC1,", "  - {kind: lcd_keypad, loop: air, step: 10 K}\n": "",
        "    - {at: 10 s, press: up, times: 3}\n": "", "initial: 20 °C": "initial: 50 °C",
    },
    "press": {
        "board: mega2560": "board: {board}", "D49": "PB4", "D52": "PA7", "D50": "PA6",
        "pin: D8,": "pin: PC7,",
    },
    "hotplate": {
        "board: uno": "board: {board}", "D11": "PD2", "clock: D2": "clock: PD3", "D12": "PB0",
        "pin: D3,": "pin: PA0,",
        "  - {kind: lcd_keypad, loop: plate, step: 5 K, countdown: {longest: 8 h}, "
        "adjust: {hysteresis: {minimum: 0.5 K, maximum: 3 K, step: 0.5 K}}}\n": "",
        "    - {at: 5 s, press: up}                # on\n": "",
        "    - {at: 6 s, press: right}             # to the time\n": "",
        "    - {at: 7 s, press: up, times: 6}      # 30 min, from the setpoint on\n": "",
    },
    # Both by interrupts of timer 1, while timer 2 makes the tick: all in one TIMSK.
    "extruder": {
        "board: mega2560": "board: {board}", "pin: A13": "pin: PA5", "pin: D10,": "pin: PC0,",
        "pin: D9,": "pin: PC1,",
    },
    # Both by timers, which leaves timer 0 for the tick.
    "extruder by timers": {
        "board: mega2560": "board: {board}", "pin: A13": "pin: PA5", "pin: D10,": "pin: PD5,",
        "pin: D9, frequency: 122 Hz": "pin: PD7, frequency: 488.28125 Hz",
    },
    # The machine's own bench had an ATmega16.
    "fabricator": {"board: atmega32": "board: {board}"},
}  # fmt: skip


def moved(name: str, board: str) -> str:
    changes = ((old, new.replace("{board}", board)) for old, new in MOVES[name].items())
    text, _, _ = changed(name.split(maxsplit=1)[0]).partition("\ncomparison:\n")
    return changed(f"{text}\n", *changes)


@pytest.mark.parametrize(
    ("name", "board"),
    [
        ("chamber", "atmega16"), ("press", "atmega32"), ("hotplate", "atmega16"),
        ("extruder", "atmega32"), ("extruder by timers", "atmega32"), ("fabricator", "atmega16"),
        ("chamber", "atmega32"), ("press", "atmega16"), ("hotplate", "atmega32"),
    ],
)  # fmt: skip
def test_all_that_is_to_be_proven_is(name: str, board: str, tmp_path: Path) -> None:
    """Closed loop, replay, every fault, timing, stack: what `verify` asks of any firmware."""
    spec = tmp_path / "spec.yaml"
    spec.write_text(moved(name, board), encoding="utf-8")
    done = CliRunner().invoke(cli, ["verify", str(spec), "--json"])
    found = json.loads(done.stdout)
    assert [each for each in found["faults"] if not each["passed"]] == []
    assert found["replay"]["ticks"] > 1000
    assert found["replay"]["mismatches"] == 0
    assert (done.exit_code, found["passed"]) == (0, True)


OLD = ("CKSEL, SUT and CKOPT", "BODEN and BODLEVEL", "4.0 V")
NEW = ("CKSEL, SUT and CKDIV8", "BODLEVEL", "4.3 V")


@pytest.mark.parametrize(
    ("board", "words"), [("atmega32", OLD), ("atmega16", OLD), ("atmega1284p", NEW), ("uno", ())]
)
def test_the_readme_of_a_bare_chip_tells_its_fuses(board: str, words: tuple[str, ...]) -> None:
    """A board has them set."""
    readme = files_of("hotplate" if board == "uno" else moved("hotplate", board))["README.md"]
    _, found, section = readme.partition("## Fuses")
    assert bool(found) is (board != "uno")
    assert all(word in section.split("##")[0] for word in (*words, *(["16 MHz"] if words else [])))
