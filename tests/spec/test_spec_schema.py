"""The JSON schema for editors: it takes what the loader takes, and refuses what has no form."""

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
from rig.specs import EXAMPLES, changed
from suite import amount

from heatwright.spec import Algorithm, Interface, Output, Sensor, kinds, load_text, units
from heatwright.spec.quantity import parse
from heatwright.spec.schema import quantity_pattern, schema
from heatwright.spec.simulation import Plant
from heatwright.spec.text import Unreadable
from heatwright.spec.tree import parse as parse_tree
from heatwright.spec.units import Dimension

DIMENSIONS = [value for value in vars(units).values() if isinstance(value, Dimension)]
TEXTS = {file.stem: file.read_text("utf-8") for file in sorted(EXAMPLES.glob("*.yaml"))}


@cache
def validator() -> Any:
    Draft202012Validator.check_schema(schema())
    return Draft202012Validator(schema())


def plain(text: str) -> Any:
    """The data of a spec as JSON has them."""
    return json.loads(json.dumps(parse_tree(text, "x").data))


def objections(text: str) -> list[str]:
    return [error.message for error in validator().iter_errors(plain(text))]


@settings(max_examples=amount("specs_for_the_schema"), suppress_health_check=list(HealthCheck))
@given(controllers())
def test_whatever_the_language_allows_fits(drawn: Drawn) -> None:
    assert objections(drawn.text) == []


def as_words(value: Any) -> Any:
    """The data with the word `off`, which YAML 1.1 takes for no."""
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
    for union in (Sensor, Output, Algorithm, Interface, Plant):
        for kind, model in kinds(union).items():
            assert definitions[model.__name__]["properties"]["kind"] == {"const": kind}


FORMLESS = (
    "there is no such key", "this key is missing", "is no kind there is", "does not say its kind",
    "is not possible", "is needed here", "is needed. Write the unit", "does not have the unit",
    "is a temperature, and a difference", "is a bare number", "is a whole number from",
    "an item is missing", "there is no value", "is not a board", "is not a pin", "cannot be a name",
    "is no state", "a master cannot write", "is no order", "a program's name has",
)  # fmt: skip
"""Of a message that a value has not the form that its key asks for, whatever else the spec says."""


def formless(name: str) -> list[str]:
    """The messages of a bad spec that tell of a form, as far as it is YAML of the language."""
    case = cases()[name]
    found = [line for line in case.messages if any(words in line for words in FORMLESS)]
    # Of an amount of which a few are possible, the schema takes all that have the unit.
    found = [line for line in found if not re.search(r"is not possible\. Use \d", line)]
    try:
        return found and plain(case.text.decode()) and found
    except Unreadable:
        return []


MISSHAPEN = [name for name in cases() if formless(name)]


def places(errors: Iterable[Any]) -> Iterator[str]:
    """Where the schema objects, also inside of one of several kinds, as messages write it."""
    for error in errors:
        yield from places(error.context)
        names = [
            f"[{step}]" if isinstance(step, int) else f".{step}" for step in error.absolute_path
        ]
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
    assert "program: start 1" in text
    assert objections(text) == []
    assert load_text(text)


def test_defaults_are_those_of_the_models() -> None:
    """A default shown to the user, written into the file, must change nothing."""
    definitions: Any = schema()["$defs"]
    active = definitions["DigitalOutput"]["properties"]["active"]["default"]
    written = changed("chamber", ("power: 240 W", f"power: 240 W, active: {active}"))
    assert load_text(written).controller == load_text(TEXTS["chamber"]).controller
    protection = definitions["Protection"]["properties"]
    defaults = {key: told["default"] for key, told in protection.items() if "default" in told}
    assert defaults == {
        "maximum_adjustable": False, "minimum": "-10 °C", "rise_rate": "5 K/s", "stale_after": "5 s"
    }  # fmt: skip


@pytest.mark.parametrize("dimension", DIMENSIONS, ids=lambda dimension: dimension.name)
@settings(max_examples=20)
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
    assert abs(parse(dimension.example, dimension)) <= dimension.largest
    assert fits(dimension.example)
    wrong = f"{number}{blank}furlong"
    with pytest.raises(PydanticCustomError):
        parse(wrong, dimension)
    assert not fits(wrong)
