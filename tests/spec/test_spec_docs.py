"""docs/language.md against the models: every key, every default, every example, every link."""

import re
from pathlib import Path
from typing import Any

import pytest

from heatwright.spec import load_text, planned
from heatwright.spec.schema import schema

TEXT = (Path(__file__).parents[2] / "docs" / "language.md").read_text(encoding="utf-8")
HEADINGS = {
    "Controller": "## The file",
    "Identity": "## controller",
    "Ds18b20": "### ds18b20",
    "Thermistor": "### thermistor",
    "Divider": "### divider",
    "BetaCurve": "### beta",
    "SteinhartHartCurve": "### Steinhart-Hart",
    "PointsCurve": "### points",
    "Rtd": "### rtd",
    "Amplifier": "### amplifier",
    "Analog": "### analog",
    "Max6675": "### max6675",
    "Max31855": "### max31855",
    "DigitalOutput": "### digital",
    "PwmOutput": "### pwm",
    "TimeProportionalOutput": "### time_proportional",
    "Stepper": "### stepper",
    "Loop": "## loops",
    "Autotune": "### autotune",
    "Setpoint": "### setpoint",
    "OnOff": "### on_off",
    "Pid": "### pid",
    "IntegralLimits": "### integral",
    "OutputLimits": "### output",
    "Protection": "## protection",
    "Heating": "### heating",
    "Runaway": "### runaway",
    "Frozen": "### frozen",
    "RisingWhileOff": "### rising_while_off",
    "Safety": "## safety",
    "LcdKeypad": "### lcd_keypad",
    "SerialPlotter": "### serial_plotter",
    "Gcode": "### gcode",
    "Simulation": "## simulation",
    "ThermalNetwork": "### thermal_network",
    "Link": "### links",
    "Sense": "### sense",
    "FanEffect": "### fans",
    "Filament": "### filament",
    "Event": "### scenario",
    "Expect": "### expect",
    "ComparisonRow": "## comparison",
    "Published": "### published",
}


def rows(heading: str) -> dict[str, list[str]]:
    """The cells of the first table under a heading, by key."""
    section = TEXT.split(f"\n{heading}\n", 1)[1]
    table = section[section.index("| key |") :].split("\n\n", 1)[0].splitlines()[2:]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in table]
    return {row[0].strip("`"): row for row in cells}


def definitions() -> dict[str, Any]:
    found: Any = schema()["$defs"]
    return dict(found)


def test_every_model_has_its_heading() -> None:
    assert set(HEADINGS) == set(definitions())


@pytest.mark.parametrize("model", HEADINGS)
def test_every_key_and_default(model: str) -> None:
    definition = definitions()[model]
    table = rows(HEADINGS[model])
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
    anchors = {heading.strip("# ").lower() for heading in re.findall(r"^#+ .*$", TEXT, re.M)}
    assert set(re.findall(r"\]\(#([^)]*)\)", TEXT)) <= anchors
    for link in re.findall(r"\]\(([^)#]+)", TEXT):
        assert (Path(__file__).parents[2] / "docs" / link).exists()


FRAGMENTS = re.findall(r"```yaml\n(\w.*?)```", TEXT, re.S)

AROUND = """\
heatwright: 1
controller: {name: oven, board: uno}
sensors:
  air: {kind: ds18b20, pin: A1}
outputs:
  heater: {kind: time_proportional, pin: D3, window: 1 s, power: 240 W}
  fan: {kind: digital, pin: D11, runs: always}
loops:
  air:
    sensor: air
    heater: heater
    period: 1 s
    setpoint: {initial: 20 °C, minimum: 10 °C, maximum: 70 °C}
    algorithm: {kind: on_off}
interfaces:
  - {kind: lcd_keypad, loop: air}
simulation:
  ambient: 20 °C
  plant:
    kind: thermal_network
    nodes: {air: 900 J/K}
    links: [{between: [air, ambient], resistance: 0.3 K/W}]
    heat: {heater: air}
    sense: {air: {node: air}}
  scenario: [{for: 1 h}]
"""


def put_in(fragment: str) -> str:
    """Put a fragment of the page in the place of its section."""
    section = fragment.split(":", 1)[0]
    if section == "algorithm":
        inner = fragment.replace("\n", "\n    ").rstrip()
        return AROUND.replace("algorithm: {kind: on_off}", inner)
    if section == "outputs" and "fan:" not in fragment:
        fragment += "  fan: {kind: digital, pin: D11, runs: always}\n"
    elif section == "outputs":
        fragment += "  heater: {kind: digital, pin: D3, power: 240 W}\n"
    if "kind: stepper" in fragment:  # somebody must move it, and a loop hold it back
        fragment += "interfaces:\n  - {kind: gcode, loops: {T0: air}, steppers: {E: feed}}\n"
        around = re.sub(r"^interfaces:\n.*\n", "", AROUND, flags=re.M)
        around = around.replace("period: 1 s", "period: 1 s\n    ready_within: 2 K")
        return re.sub(r"^outputs:\n(?: .*\n)*", "", around, flags=re.M) + fragment
    around = AROUND
    if "kind: max6675" in fragment:  # it may be wrong by 5.25 K, and ends at 0 °C
        cold = "algorithm: {kind: on_off}\n    protection: {minimum: 6 °C}"
        around = around.replace("algorithm: {kind: on_off}", cold)
    kept = re.sub(rf"^{section}:.*\n(?:[ -].*\n)*", "", around, flags=re.M)
    return f"{kept}{fragment}"


@pytest.mark.parametrize("fragment", FRAGMENTS, ids=lambda text: text[:40].replace("\n", " "))
def test_examples_are_right(fragment: str) -> None:
    assert fragment.strip()
    parts = fragment.split("\nalgorithm:") if fragment.startswith("algorithm:") else [fragment]
    for part in parts:
        load_text(put_in(part if part is parts[0] else f"algorithm:{part}"))


def test_what_is_planned_is_told() -> None:
    told = set(re.findall(r"`(\w+)`", TEXT.split("## Planned")[1]))
    for words in (*planned.KINDS.values(), *planned.KEYS.values()):
        for word in words.split():
            assert word in told


def test_boards_are_told() -> None:
    for name in definitions()["Identity"]["properties"]["board"]["enum"]:
        assert f"`{name}`" in rows("## controller")["board"][1]
