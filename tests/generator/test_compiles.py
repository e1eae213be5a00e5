"""Firmware of every shape compiles without a warning, each file by itself, and links."""

import re
from collections.abc import Callable, Mapping
from pathlib import Path

import commanded
import fired
import mastered
import pytest
import switching
from chip import compile_and_link
from jinja2 import UndefinedError
from matrix import CHOICES, Row, can_be, pairs, pairwise, spec_of, variant

from heatwright.generator import plan_firmware, render
from heatwright.generator.plan import File, Plan
from heatwright.spec import BOARDS, load_text
from heatwright.spec.names import LONGEST_NAME

Generate = Callable[..., Mapping[str, str]]
TEMPLATES = Path(__file__).parents[2] / "templates"
ROWS = pairwise()
COMMANDED = commanded.pairwise()
MASTERED = mastered.pairwise()


def name_of(row: Row) -> str:
    return "-".join((row["board"], row["output"], row["algorithm"], row["interface"]))


@pytest.mark.parametrize("row", ROWS, ids=name_of)
def test_it_compiles_and_links(row: Row, generate: Generate, tmp_path: Path) -> None:
    text = spec_of(row)
    files = generate(text)
    unused = [name for name in defined(files["src/config.h"]) if not used(name, files)]
    assert unused == []
    assert compile_and_link(files, tmp_path, load_text(text).controller.board).is_file()


@pytest.mark.parametrize("row", COMMANDED, ids=lambda row: f"{row['board']}-{row['tools']}")
def test_what_a_host_commands_does_too(row: Row, generate: Generate, tmp_path: Path) -> None:
    text = commanded.spec_of(row)
    files = generate(text)
    assert [name for name in defined(files["src/config.h"]) if not used(name, files)] == []
    assert compile_and_link(files, tmp_path, load_text(text).controller.board).is_file()


@pytest.mark.parametrize("row", MASTERED, ids=lambda row: f"{row['board']}-{row['form']}")
def test_what_a_master_commands_does_too(row: Row, generate: Generate, tmp_path: Path) -> None:
    text = mastered.spec_of(row)
    files = generate(text)
    assert [name for name in defined(files["src/config.h"]) if not used(name, files)] == []
    assert compile_and_link(files, tmp_path, load_text(text).controller.board).is_file()


def defined(config: str) -> list[str]:
    return re.findall(r"^#define (\w+) .+$", config, re.MULTILINE)


def used(name: str, files: Mapping[str, str]) -> bool:
    code = (text for path, text in files.items() if path.endswith((".c", ".h")))
    return sum(len(re.findall(rf"\b{name}\b", text)) for text in code) > 1


def test_the_rows_hold_every_choice_and_pair() -> None:
    assert set(CHOICES["board"]) == set(BOARDS)
    for choice, values in CHOICES.items():
        assert {row[choice] for row in ROWS} == set(values)
    assert all(can_be(row) for row in ROWS)
    shown = frozenset().union(*map(pairs, ROWS))
    for board in CHOICES["board"]:
        for output in CHOICES["output"]:
            assert (("board", board), ("output", output)) in shown
    # On-off: with or without lead and band. PID: P, PI in two ways, PD in two, PID in four.
    assert len({variant(row) for row in ROWS}) == 4 + 9
    for choice, values in commanded.CHOICES.items():
        assert {row[choice] for row in COMMANDED} == set(values)
    for choice, values in mastered.CHOICES.items():
        assert {row[choice] for row in MASTERED} == set(values)
    # Another draw finds no pair that could be and is not there.
    assert frozenset().union(*map(pairs, pairwise(seed=2))) == shown


def test_every_template_is_used() -> None:
    switched = map(switching.spec_of, switching.pairwise())
    texts = [*map(spec_of, ROWS), *map(commanded.spec_of, COMMANDED), *switched]
    texts += map(mastered.spec_of, MASTERED)
    texts += map(fired.spec_of, fired.pairwise())
    specs = [load_text(text) for text in texts]
    used_here = {file.template for spec in specs for file in plan_firmware(spec).files}
    there_are = {
        path.relative_to(TEMPLATES).as_posix()
        for path in TEMPLATES.glob("*/*")
        if path.suffix in {".c", ".h", ".j2"}
    }
    assert with_included(used_here) == there_are


def with_included(templates: set[str]) -> set[str]:
    """Add what these include or extend."""
    found, left = set(templates), list(templates)
    while left:
        text = (TEMPLATES / left.pop()).read_text("utf-8")
        named = set(re.findall(r'(?:{%|//%) (?:include|extends) "([^"]+)"', text))
        left += named - found
        found |= named
    return found


def test_an_undefined_name_is_an_error() -> None:
    file = File("src/clock.c", "src/clock.c.j2", {"tick_ms": 10})
    with pytest.raises(UndefinedError, match="'tick' is undefined"):
        render(Plan("name", "banner", (file,)))


@pytest.mark.parametrize("name", ["ticks", "fault", "i_2", "w" * LONGEST_NAME])
def test_a_name_may_be_any_word_of_the_firmware(
    name: str, generate: Generate, tmp_path: Path
) -> None:
    """One name for sensor, output and loop at once, and one the firmware uses itself."""
    text = f"""
heatwright: 1
controller: {{name: {name}, board: mega2560}}
sensors: {{{name}: {{kind: ds18b20, pin: A1}}}}
outputs: {{{name}: {{kind: digital, pin: D22, power: 100 W}}}}
loops:
  {name}:
    sensor: {name}
    heater: {name}
    period: 1 s
    setpoint: {{initial: 20 °C, minimum: 10 °C, maximum: 70 °C, stored: true}}
    algorithm: {{kind: on_off, lead: 2 s}}
interfaces: [{{kind: lcd_keypad, loop: {name}}}, {{kind: serial_plotter, loop: {name}}}]
"""
    compile_and_link(generate(text), tmp_path, BOARDS["mega2560"])


@pytest.mark.parametrize("clock_mhz", [8, 14.7456, 20])
def test_another_crystal(clock_mhz: float, generate: Generate, tmp_path: Path) -> None:
    """PlatformIO is told of it, and no other clock compiles: every time would be wrong."""
    row = {**ROWS[0], "board": "atmega328p", "output": "digital", "algorithm": "on_off"}
    text = spec_of({**row, "interface": "none", "loops": "1"})
    text = text.replace("atmega328p}", f"atmega328p, clock: {clock_mhz} MHz}}")
    files = generate(text)
    board = load_text(text).controller.board
    assert board.clock_hz == round(clock_mhz * 1e6)
    assert f"\nboard_build.f_cpu = {board.clock_hz}L\n" in files["platformio.ini"]
    compile_and_link(files, tmp_path / "right", board)
    with pytest.raises(AssertionError, match=f"generated for a {clock_mhz:g} MHz clock"):
        compile_and_link(files, tmp_path / "wrong", BOARDS["atmega328p"])
    with pytest.raises(AssertionError, match="choose that board"):
        compile_and_link(files, tmp_path / "other", board._replace(mcu="atmega2560"))


def test_the_boards_own_clock_is_left_to_platformio(chamber_files: Mapping[str, str]) -> None:
    assert "f_cpu" not in chamber_files["platformio.ini"]
