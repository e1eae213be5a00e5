import json
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from pydantic_core import PydanticCustomError

from heatwright.spec import Algorithm, Interface, Output, Sensor, SpecError, kinds, load_text, units
from heatwright.spec.quantity import parse
from heatwright.spec.schema import quantity_pattern, schema
from heatwright.spec.simulation import Plant
from heatwright.spec.tree import parse as parse_tree
from heatwright.spec.units import Dimension

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "spec" / "examples").glob("*.yaml"))
DIMENSIONS = [value for value in vars(units).values() if isinstance(value, Dimension)]


@pytest.fixture(scope="module")
def validator() -> Any:
    Draft202012Validator.check_schema(schema())
    return Draft202012Validator(schema())


def plain(value: Any) -> Any:
    """Tuples to lists, as JSON has them."""
    return json.loads(json.dumps(value))


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_examples_fit(validator: Any, file: Path) -> None:
    data = plain(parse_tree(file.read_text(encoding="utf-8"), file.name).data)
    assert [error.message for error in validator.iter_errors(data)] == []


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_an_editors_yaml_reads_the_same(file: Path) -> None:
    """Editors read YAML in their own way; of our examples it must make the same."""
    ours = plain(parse_tree(file.read_text(encoding="utf-8"), file.name).data)

    def words(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: words(inner) for key, inner in value.items()}
        if isinstance(value, list):
            return [words(inner) for inner in value]
        return "off" if value is False else value  # YAML 1.1

    assert words(yaml.safe_load(file.read_text(encoding="utf-8"))) == words(ours)


def test_every_key_and_kind_is_described(validator: Any) -> None:
    del validator
    definitions: Any = schema()["$defs"]
    for definition in definitions.values():
        assert definition["description"]
        assert definition["additionalProperties"] is False
        for key, described in definition["properties"].items():
            assert key == "kind" or described["description"].endswith(".")
    for union in (Sensor, Output, Algorithm, Interface, Plant):
        for kind, model in kinds(union).items():
            assert definitions[model.__name__]["properties"]["kind"] == {"const": kind}


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("period: 1 s", "perid: 1 s"),
        ("period: 1 s", "period: 1"),
        ("period: 1 s", "period: 1 K"),
        ("pin: D3", "pin: 3"),
        ("kind: on_off", "kind: onoff"),
        ("board: uno", "board: unno"),
        ("resolution: 12 bit", "resolution: 12"),
        ("baud: 9600", "baud: fast"),
        ("watchdog: 2 s", "watchdog: 2"),
        ("    sensor: air\n", ""),
        ("heatwright: 1", "heatwright: 2"),
        ("between: [air, walls]", "between: [air]"),
        ("times: 3", "times: 0"),
        ("runs: always", "runs: sometimes"),
    ],
)
def test_what_the_schema_refuses_the_loader_refuses(validator: Any, old: str, new: str) -> None:
    text = (ROOT / "spec" / "examples" / "chamber.yaml").read_text(encoding="utf-8")
    assert old in text
    text = text.replace(old, new, 1)
    assert not validator.is_valid(plain(parse_tree(text, "x").data))
    with pytest.raises(SpecError):
        load_text(text)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("parity: even", "parity: mark"),
        ("address: 1", "address: 248"),
        ("baud: 19200", "baud: fast"),
        ("linuxcnc: true", "linuxcnc: yes"),
        ("limit: 3 A", "limit: 3"),
        ("scale: 0.2 V/A", "scale: 0.2 V"),
        ("dead_band: 2 K", "dead_band: 2 °C"),
        ("starts: disabled", "starts: later"),
        ("PB0: enabled", "PB0: off"),
        ("PB0: enabled", "PB9: enabled"),
        ("master_lost_after: 5 s", "master_lost_after: off"),
        ("write: {nozzle.setpoint: 30 °C}", "write: {nozzle.speed: 30 °C}"),
        ("write: {nozzle.enabled: false}", "write: {nozzle.enabled: 0}"),
        ("write: {nozzle.enabled: false}", "write: {acknowledge: false}"),
    ],
)
def test_of_the_bus_too(validator: Any, old: str, new: str) -> None:
    text = (ROOT / "spec" / "examples" / "fabricator.yaml").read_text(encoding="utf-8")
    assert old in text
    text = text.replace(old, new, 1)
    assert not validator.is_valid(plain(parse_tree(text, "x").data))
    with pytest.raises(SpecError):
        load_text(text)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("thermocouple: K", "thermocouple: C"),
        ("selectable: [K, S]", "selectable: K"),
        ("mains_filter: 50 Hz", "mains_filter: 50"),
        ("average: 2 ", "average: 3 "),
        ("moving_average: 5", "moving_average: 17"),
        ("  points: 10 ", "  points: 21 "),
        ("otherwise: stop", "otherwise: resume"),
        ("resume_within: 30 K", "resume_within: 30"),
        ("within: 10 K", "within: 10"),
        ("name: fuse", "name: fused for long"),
        ("{hold: 30 min}", "{hold: forever}"),
        ("{hold: 30 min}", "{holds: 30 min}"),
        ("over: 60 min", "at: 540 °C"),
        ("relay_feedback: D9", "relay_feedback: 9"),
        ("maximum_adjustable: true", "maximum_adjustable: off"),
        ("port: 1", "port: 4"),
        ("every: 1 min", "every: 60"),
        ("entries: 600", "entries: 1001"),
        ("entries: 600", "keep: sd"),
        ("baud: 115200", "baud: fast"),
        ("emissivity: 0.3", "emissivity: 1.3"),
        ("area: 0.005 m²", "area: 0.005 m"),
        ("tracking: 1 K", "tracking: 1 °C"),
        ('send: "#8 1;"', "program: start"),
    ],
)
def test_of_the_kiln_too(validator: Any, old: str, new: str) -> None:
    text = (ROOT / "spec" / "examples" / "kiln.yaml").read_text(encoding="utf-8")
    assert old in text
    text = text.replace(old, new, 1)
    assert not validator.is_valid(plain(parse_tree(text, "x").data))
    with pytest.raises(SpecError):
        load_text(text)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("hold_back: {within: 10 K, limit: 60 min}", "hold_back: 10 K"),
        ("{resume_within: 30 K, otherwise: stop}", "stop"),
        ("over: 60 min", "at: 500 K/h"),
        ("over: 60 min", "at: as fast as possible"),
        ("{hold: 30 min}", "{hold: until operator}"),
        ('send: "#8 1;"', "program: start 1"),
    ],
)
def test_other_forms_fit_too(validator: Any, old: str, new: str) -> None:
    text = (ROOT / "spec" / "examples" / "kiln.yaml").read_text(encoding="utf-8")
    assert old in text
    text = text.replace(old, new, 1)
    data = plain(parse_tree(text, "x").data)
    assert [error.message for error in validator.iter_errors(data)] == []
    assert load_text(text)


def test_defaults_are_those_of_the_models() -> None:
    """A default shown to the user, written into the file, must change nothing."""
    text = (ROOT / "spec" / "examples" / "chamber.yaml").read_text(encoding="utf-8")
    definitions: Any = schema()["$defs"]
    runs = definitions["DigitalOutput"]["properties"]["active"]["default"]
    written = text.replace("power: 240 W", f"power: 240 W, active: {runs}")
    assert load_text(written).controller == load_text(text).controller
    defaults = {
        key: described["default"]
        for key, described in definitions["Protection"]["properties"].items()
        if "default" in described
    }
    assert defaults == {
        "maximum_adjustable": False,
        "minimum": "-10 °C",
        "rise_rate": "5 K/s",
        "stale_after": "5 s",
    }


@pytest.mark.parametrize("dimension", DIMENSIONS, ids=lambda dimension: dimension.name)
@given(number=st.sampled_from(["1", "-2.5", "+.5", "1e3", "1.", "5e-1"]), data=st.data())
def test_patterns_take_what_the_loader_takes(
    dimension: Dimension, number: str, data: st.DataObject
) -> None:
    fits = Draft202012Validator(
        {"type": "string", "pattern": f"^\\s*{quantity_pattern(dimension)}\\s*$"}
    ).is_valid
    unit = data.draw(st.sampled_from(sorted(dimension.units)))
    blank = data.draw(st.sampled_from(["", " "]))
    text = f"{number}{blank}{unit}".replace("2K", "²K").replace("μ", "u")
    parse(text, dimension)
    assert fits(text)
    assert fits(dimension.example)
    wrong = f"{number}{blank}furlong"
    with pytest.raises(PydanticCustomError):
        parse(wrong, dimension)
    assert not fits(wrong)
