"""docs/language.md against the models: every key, every default, every example, every link."""

import re
from pathlib import Path
from typing import Any

import pytest
import yaml
from rig.bad_specs import bases

from heatwright.spec import BOARDS, Board, load_text
from heatwright.spec.schema import schema

DOCS = Path(__file__).parents[2] / "docs"
TEXT = (DOCS / "language.md").read_text(encoding="utf-8")
DEFINITIONS: dict[str, Any] = dict(schema()["$defs"])  # type: ignore[arg-type]
HEADINGS = {
    "Controller": "The file", "Identity": "controller", "BetaCurve": "beta",
    "SteinhartHartCurve": "Steinhart-Hart", "PointsCurve": "points", "CurrentSensor": "current",
    "DigitalOutput": "digital", "PwmOutput": "pwm", "Current": "heater current",
    "TimeProportionalOutput": "time_proportional", "Loop": "loops", "Link": "links",
    "IntegralLimits": "integral", "OutputLimits": "output", "Segment": "segments",
    "FanEffect": "fans", "Event": "scenario", "ComparisonRow": "comparison",
}  # fmt: skip
"""Of the models whose heading is not their own name."""


def rows(model: str) -> dict[str, list[str]]:
    """The cells of the first table under a model's heading, by key."""
    own = re.sub(r"(?<!^)(?=[A-Z])", "_", model).lower()
    found = re.search(rf"(?ms)^###? {HEADINGS.get(model, own)}\n.*?^(\| key \|.*?)\n\n", TEXT)
    assert found is not None, f"{model} has no heading"
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in found[1].split("\n")]
    return {row[0].strip("`"): row for row in cells[2:]}


@pytest.mark.parametrize("model", DEFINITIONS)
def test_every_key_and_default(model: str) -> None:
    definition, table = DEFINITIONS[model], rows(model)
    assert list(table) == list(definition["properties"])
    for key, described in definition["properties"].items():
        _, _, default, *_ = table[key]
        if key in definition["required"]:
            assert default == "needed"
        elif "default" in described:
            shown = described["default"]
            assert default == (str(shown).lower() if isinstance(shown, bool) else str(shown))
        else:
            assert default != "needed"


def test_links_lead_somewhere() -> None:
    headings = re.findall(r"^#+ (.*)$", TEXT, re.M)
    anchors = {heading.lower().replace(" ", "-") for heading in headings}
    assert set(re.findall(r"\]\(#([^)]*)\)", TEXT)) <= anchors
    assert all((DOCS / link).exists() for link in re.findall(r"\]\(([^)#]+)", TEXT))


FRAGMENTS = re.findall(r"```yaml\n(\w.*?)```", TEXT, re.S)
FAN = "{kind: digital, pin: D11, runs: always}"
HEATER = "{kind: digital, pin: D3, power: 240 W}"


def read(text: str) -> Any:
    return yaml.load(text, yaml.BaseLoader)  # noqa: S506 - it makes only texts


def flow(value: Any) -> str:
    """Write what was read on one line."""
    if isinstance(value, dict):
        return f"{{{', '.join(f'{key}: {flow(inner)}' for key, inner in value.items())}}}"
    return f"[{', '.join(map(flow, value))}]" if isinstance(value, list) else str(value)


def put_in(fragment: str) -> str:
    """Put a fragment of the page in the place of its sections, and around it what it needs."""
    around, given = read(bases()["simulated_pid_oven"]), read(fragment)
    around["interfaces"] = read("[{kind: lcd_keypad, loop: air}]")
    around["outputs"]["fan"] = FAN
    loop, plant = around["loops"]["air"], around["simulation"]["plant"]
    loop["algorithm"] = given.get("algorithm", "{kind: on_off}")
    if "three_position" in fragment:
        loop["cooler"] = "cooler"
        around["outputs"]["cooler"] = "{kind: digital, pin: D12}"
        plant["fans"] = "{cooler: {link: [air, ambient], factor: 4}}"
    if "kind: stepper" in fragment:  # somebody must move it, and a loop hold it back
        loop["ready_within"] = "2 K"
        around["interfaces"] = "[{kind: gcode, loops: {T0: air}, steppers: {E: feed}}]"
    if "kind: max6675" in fragment:  # it may be wrong by 5.25 K, and ends at 0 °C
        loop["protection"] = "{minimum: 6 °C}"
    if "kind: current" in fragment:  # the plant must have it
        plant["sense"]["wire"] = "{of: heater}"
    rest = [f"{key}: {flow(value)}\n" for key, value in around.items() if key not in given]
    lines = [] if "algorithm" in given else [fragment]
    if "outputs" in given:
        needed = {"heater": HEATER, "fan": FAN}
        missing = [name for name in needed if name not in given["outputs"]]
        assert list(given)[-1] == "outputs"
        lines += [f"  {name}: {needed[name]}\n" for name in missing]
    return "".join([*rest, *lines])


@pytest.mark.parametrize("fragment", FRAGMENTS, ids=lambda text: text[:40].replace("\n", " "))
def test_examples_are_right(fragment: str) -> None:
    for part in re.split(r"\n(?=algorithm:)", fragment):
        assert load_text(put_in(part))


def test_boards_are_told() -> None:
    for name in DEFINITIONS["Identity"]["properties"]["board"]["enum"]:
        assert f"`{name}`" in rows("Identity")["board"][1]


def timers(board: Board, bits: int) -> str:
    """The timers of so many bits, each with its compare outputs."""
    pins = dict.fromkeys(pin for pin in board.pins.values() if pin.pwm)
    return ", ".join(
        f"{number}: {' '.join(pin.name for pin in pins if pin.pwm and pin.pwm[0] == number)}"
        for number, timer in board.timers.items()
        if timer.bits == bits
    )


def test_the_table_of_boards_is_current() -> None:
    told = re.findall(r"^\| `(\w+)` \| (\d+) \| (\d+) \| (\d+) \| (.*?) \| (.*?) \|$", TEXT, re.M)
    assert told == [
        (
            name, str(board.flash_bytes - board.bootloader_bytes), str(board.ram_bytes),
            str(board.eeprom_bytes), timers(board, 8), timers(board, 16),
        )
        for name, board in BOARDS.items()
    ]  # fmt: skip
