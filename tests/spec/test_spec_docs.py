"""docs/language.md against the models: every key, every default, every example, every link."""

import re
from pathlib import Path
from typing import Any

import pytest

from heatwright.spec import BOARDS, Board, load_text
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
    "CurrentSensor": "### current",
    "Max6675": "### max6675",
    "Max31855": "### max31855",
    "Max31856": "### max31856",
    "DigitalOutput": "### digital",
    "PwmOutput": "### pwm",
    "Current": "### heater current",
    "TimeProportionalOutput": "### time_proportional",
    "Stepper": "### stepper",
    "Loop": "## loops",
    "Autotune": "### autotune",
    "Setpoint": "### setpoint",
    "OnOff": "### on_off",
    "ThreePosition": "### three_position",
    "Pid": "### pid",
    "IntegralLimits": "### integral",
    "OutputLimits": "### output",
    "Protection": "## protection",
    "Heating": "### heating",
    "Runaway": "### runaway",
    "Frozen": "### frozen",
    "RisingWhileOff": "### rising_while_off",
    "Programs": "## programs",
    "Program": "### program",
    "Segment": "### segments",
    "HoldBack": "### hold_back",
    "AfterPowerLoss": "### after_power_loss",
    "Safety": "## safety",
    "LcdKeypad": "### lcd_keypad",
    "SerialPlotter": "### serial_plotter",
    "Nextion": "### nextion",
    "SerialLog": "### serial_log",
    "Gcode": "### gcode",
    "ModbusRtu": "### modbus_rtu",
    "Indicators": "### indicators",
    "Simulation": "## simulation",
    "ThermalNetwork": "### thermal_network",
    "Link": "### links",
    "Radiation": "### radiation",
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
    anchors = {
        heading.strip("# ").lower().replace(" ", "-")
        for heading in re.findall(r"^#+ .*$", TEXT, re.M)
    }
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


COOLED = {
    "outputs:\n": "outputs:\n  cooler: {kind: digital, pin: D12}\n",
    "    heater: heater\n": "    heater: heater\n    cooler: cooler\n",
    "    heat: {heater: air}\n": "    heat: {heater: air}\n"
    "    fans: {cooler: {link: [air, ambient], factor: 4}}\n",
}
"""What a loop of three positions needs around it."""


def without(section: str, text: str) -> str:
    return re.sub(rf"^{section}:.*\n(?:[ -].*\n)*", "", text, flags=re.M)


def put_in(fragment: str) -> str:
    """Put a fragment of the page in the place of its sections."""
    sections = re.findall(r"^(\w+):", fragment, re.M)
    if sections == ["algorithm"]:
        around = AROUND
        for old, new in COOLED.items() if "three_position" in fragment else ():
            around = around.replace(old, new)
        return around.replace(
            "algorithm: {kind: on_off}", fragment.replace("\n", "\n    ").rstrip()
        )
    if sections == ["outputs"] and "fan:" not in fragment:
        fragment += "  fan: {kind: digital, pin: D11, runs: always}\n"
    elif sections == ["outputs"]:
        fragment += "  heater: {kind: digital, pin: D3, power: 240 W}\n"
    around = AROUND
    if "kind: stepper" in fragment:  # somebody must move it, and a loop hold it back
        fragment += "interfaces:\n  - {kind: gcode, loops: {T0: air}, steppers: {E: feed}}\n"
        around = around.replace("period: 1 s", "period: 1 s\n    ready_within: 2 K")
        sections.append("interfaces")
    if "kind: max6675" in fragment:  # it may be wrong by 5.25 K, and ends at 0 °C
        cold = "algorithm: {kind: on_off}\n    protection: {minimum: 6 °C}"
        around = around.replace("algorithm: {kind: on_off}", cold)
    if "kind: current" in fragment:  # the plant must have it
        around = around.replace("sense: {", "sense: {wire: {of: heater}, ")
    for section in sections:
        around = without(section, around)
    return f"{around}{fragment}"


@pytest.mark.parametrize("fragment", FRAGMENTS, ids=lambda text: text[:40].replace("\n", " "))
def test_examples_are_right(fragment: str) -> None:
    assert fragment.strip()
    parts = fragment.split("\nalgorithm:") if fragment.startswith("algorithm:") else [fragment]
    for part in parts:
        load_text(put_in(part if part is parts[0] else f"algorithm:{part}"))


def test_boards_are_told() -> None:
    for name in definitions()["Identity"]["properties"]["board"]["enum"]:
        assert f"`{name}`" in rows("## controller")["board"][1]


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
