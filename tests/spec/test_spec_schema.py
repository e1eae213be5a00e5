"""The JSON schema for editors takes what the loader takes; docs/language.md tells all of it."""

import json
import re
from collections.abc import Iterable, Iterator
from functools import cache
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from pydantic_core import PydanticCustomError
from rig.bad_specs import bases, cases
from rig.controllers import Drawn, controllers
from rig.firmware import EXAMPLES, ROOT, changed, flow
from suite import amount

from heatwright import spec as language
from heatwright.spec import BOARDS, Board, kinds, load_text, units
from heatwright.spec.loading.schema import quantity_pattern, schema
from heatwright.spec.loading.text import Unreadable
from heatwright.spec.loading.tree import parse as parse_tree
from heatwright.spec.quantity import parse
from heatwright.spec.units import Dimension

DIMENSIONS = [value for value in vars(units).values() if isinstance(value, Dimension)]
TEXTS = {file.stem: file.read_text("utf-8") for file in sorted(EXAMPLES.glob("*.yaml"))}


@cache
def validator() -> Any:
    Draft202012Validator.check_schema(schema())
    return Draft202012Validator(schema())


def plain(text: str) -> Any:
    return json.loads(json.dumps(parse_tree(text, "x").data))


def objections(text: str) -> list[str]:
    return [error.message for error in validator().iter_errors(plain(text))]


@settings(max_examples=amount("specs_for_the_schema"), suppress_health_check=list(HealthCheck))
@given(controllers())
def test_whatever_the_language_allows_fits(drawn: Drawn) -> None:
    assert objections(drawn.text) == []


def as_words(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: as_words(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [as_words(inner) for inner in value]
    return "off" if value is False else value


@pytest.mark.parametrize("example", TEXTS)
def test_examples_fit(example: str) -> None:
    """As we read them, and as an editor does."""
    assert objections(TEXTS[example]) == []
    assert as_words(yaml.safe_load(TEXTS[example])) == as_words(plain(TEXTS[example]))


def test_every_key_and_kind_is_described() -> None:
    definitions: Any = schema()["$defs"]
    for definition in definitions.values():
        assert definition["description"]
        assert definition["additionalProperties"] is False
        for key, described in definition["properties"].items():
            assert key == "kind" or described["description"].endswith(".")
    for name in ("Sensor", "Output", "Algorithm", "Interface", "Plant"):
        for kind, model in kinds(vars(language)[name]).items():
            assert definitions[model.__name__]["properties"]["kind"] == {"const": kind}


FORMLESS = (
    "there is no such key", "this key is missing", "is not a known kind", "this entry has no kind",
    "is not possible", "is needed here", "is needed. Write the unit", "does not have the unit",
    "is a temperature, and a difference", "is a bare number", "must be a whole number from",
    "an item is missing", "there is no value", "is not a board", "is not a pin", "cannot be a name",
    "a line to send has", "this text has a line break",
    "is no state", "a master cannot write", "is no command", "a program's name has",
)  # fmt: skip
"""Parts of messages that a value lacks the form of its key, whatever else the spec says."""


def formless(name: str) -> list[str]:
    case = cases()[name]
    found = [line for line in case.messages if any(words in line for words in FORMLESS)]
    try:
        return found and plain(case.text.decode()) and found
    except Unreadable:
        return []


MISSHAPEN = [name for name in cases() if formless(name)]


def places(errors: Iterable[Any]) -> Iterator[str]:
    for error in errors:
        yield from places(error.context)
        path = error.absolute_path
        names = [f"[{step}]" if isinstance(step, int) else f".{step}" for step in path]
        yield "".join(names).removeprefix(".")


@pytest.mark.parametrize("name", MISSHAPEN)
def test_what_has_no_form_is_refused_in_its_place(name: str) -> None:
    """At the key of the message, inside of it, or in what holds it."""
    found = list(places(validator().iter_errors(plain(cases()[name].text.decode()))))
    for message in formless(name):
        path = message.split(": ")[1]
        holder = re.sub(r"(\.?\w+|\[\d+\])$", "", path)
        assert any(place == holder or place.startswith(path) for place in found), message


@pytest.mark.parametrize("words", FORMLESS)
def test_every_form_is_missed_by_some_spec(words: str) -> None:
    assert any(words in line for name in MISSHAPEN for line in formless(name))


def test_short_forms_fit_too() -> None:
    keys = "  hold_back: 10 K\n  after_power_loss: stop\n  stored:"
    text = changed(bases()["simulated_kiln"], ("  stored:", keys))
    assert ("program: start 1" in text, objections(text)) == (True, [])
    assert load_text(text)


@pytest.mark.parametrize("dimension", DIMENSIONS, ids=lambda dimension: dimension.name)
@settings(max_examples=20)
@given(number=st.sampled_from(["1", "-2.5", "+.5", "1e3", "1.", "5e-1"]), data=st.data())
def test_patterns_take_what_the_loader_takes(
    dimension: Dimension, number: str, data: st.DataObject
) -> None:
    pattern = f"^\\s*{quantity_pattern(dimension)}\\s*$"
    fits = Draft202012Validator({"type": "string", "pattern": pattern}).is_valid
    unit = data.draw(st.sampled_from(sorted(dimension.units)))
    blank = data.draw(st.sampled_from(["", " "]))
    text = f"{number}{blank}{unit}".replace("2K", "²K").replace("μ", "u")
    parse(text, dimension)
    assert fits(text)
    assert abs(parse(dimension.example, dimension)) <= dimension.largest
    assert fits(dimension.example)
    wrong = f"{number}{blank}furlong"
    with pytest.raises(PydanticCustomError):
        parse(wrong, dimension)
    assert not fits(wrong)


TEXT = (ROOT / "docs" / "language.md").read_text(encoding="utf-8")
DEFINITIONS: dict[str, Any] = dict(schema()["$defs"])  # type: ignore[arg-type]
HEADINGS = {
    "Controller": "The file", "Identity": "controller", "BetaCurve": "beta",
    "SteinhartHartCurve": "Steinhart-Hart", "PointsCurve": "points", "CodesCurve": "codes",
    "CurrentSensor": "current",
    "DigitalOutput": "digital", "PwmOutput": "pwm", "Current": "heater current",
    "TimeProportionalOutput": "time_proportional", "Loop": "loops", "Link": "links",
    "IntegralLimits": "integral", "OutputLimits": "output", "Segment": "segments",
    "FanEffect": "fans", "Event": "scenario", "ComparisonRow": "comparison",
    **dict.fromkeys(("DifferenceRange", "DurationRange", "GainRange"), "range of a number"),
    "Monitor": "monitors", "ThermistorTolerances": "tolerances of a thermistor",
    "RtdTolerances": "tolerances of an rtd", "VoltageTolerances": "tolerances of a voltage",
}  # fmt: skip
"""Headings of the models that do not have their own names."""


def rows(model: str) -> dict[str, list[str]]:
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


FRAGMENTS = re.findall(r"```yaml\n(\w.*?)```", TEXT, re.S)
NEEDED = {
    "heater": "{kind: digital, pin: D3, power: 240 W}",
    "fan": "{kind: digital, pin: D11, runs: always}",
}  # Outputs, where a fragment has others


def read(text: str) -> Any:
    return yaml.load(text, yaml.BaseLoader)  # noqa: S506 - it makes only texts


def put_in(fragment: str) -> str:
    """Put a fragment of the page in the place of its sections, and around it what it needs."""
    around, given = read(bases()["simulated_pid_oven"]), read(fragment)
    around["interfaces"] = read("[{kind: lcd_keypad, loop: air}]")
    around["outputs"]["fan"] = NEEDED["fan"]
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
    if "proof:" in fragment:
        loop["fan"] = "fan"
    if "monitors:" in fragment:
        plant["sense"]["electronics"] = "{node: air}"
    if "kind: current" in fragment:  # the plant must have it
        plant["sense"]["wire"] = "{of: heater}"
    rest = [f"{key}: {flow(value)}\n" for key, value in around.items() if key not in given]
    lines = [] if "algorithm" in given else [fragment]
    if "outputs" in given:
        assert list(given)[-1] == "outputs"
        lines += [f"  {name}: {said}\n" for name, said in NEEDED.items()
                  if name not in given["outputs"]]  # fmt: skip
    return "".join([*rest, *lines])


@pytest.mark.parametrize("fragment", FRAGMENTS, ids=lambda text: text[:40].replace("\n", " "))
def test_examples_are_right(fragment: str) -> None:
    for part in re.split(r"\n(?=algorithm:)", fragment):
        assert load_text(put_in(part))


def timers(board: Board, bits: int) -> str:
    pins = dict.fromkeys(pin for pin in board.pins.values() if pin.pwm)
    return ", ".join(
        f"{number}: {' '.join(pin.name for pin in pins if pin.pwm and pin.pwm[0] == number)}"
        for number, timer in board.timers.items()
        if timer.bits == bits
    )


def test_boards_are_told_and_their_table_is_current() -> None:
    for name in DEFINITIONS["Identity"]["properties"]["board"]["enum"]:
        assert f"`{name}`" in rows("Identity")["board"][1]
    told = re.findall(r"^\| `(\w+)` \| (\d+) \| (\d+) \| (\d+) \| (.*?) \| (.*?) \|$", TEXT, re.M)
    assert told == [
        (
            name, str(board.flash_bytes - board.bootloader_bytes), str(board.ram_bytes),
            str(board.eeprom_bytes), timers(board, 8), timers(board, 16),
        )
        for name, board in BOARDS.items()
    ]  # fmt: skip
