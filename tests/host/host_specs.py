"""Specifications that, between them, take every branch of the templates under test."""

from copy import deepcopy
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import yaml

from heatwright.spec import Spec, load_text

_FAMILIES = yaml.load(
    Path(__file__).with_suffix(".yaml").read_text(encoding="utf-8"),
    yaml.BaseLoader,  # noqa: S506 - everything is text: "off" is a word of the language
)
NOTHING = "null"
_EXAMPLES = ("extruder", "feeder")


def _put(place: Any, path: str, value: Any) -> None:
    """Put a value at a path like `loops.air.period`; NOTHING takes away what is there."""
    *way, last = (int(part) if part.isdecimal() else part for part in path.split("."))
    for part in way:
        place = place[part] if isinstance(place, list) else place.setdefault(part, {})
    if value == NOTHING:
        place.pop(last)
    else:
        place[last] = deepcopy(value)


def _text(*changes: dict[str, Any]) -> str:
    spec: dict[str, Any] = {}
    for change in changes:
        for path, value in change.items():
            _put(spec, path, value)
    return "".join(f"{key}: {_flow(value)}\n" for key, value in spec.items() if value)


def _flow(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_flow(each)}" for key, each in value.items()) + "}"
    return "[" + ", ".join(map(_flow, value)) + "]" if isinstance(value, list) else str(value)


def _family(name: str) -> dict[str, str]:
    base, *variants = _FAMILIES[name].items()
    return {each: _text(_FAMILIES["all"], base[1], change) for each, change in variants}


def _example(name: str) -> str:
    return files("heatwright.spec.examples").joinpath(f"{name}.yaml").read_text(encoding="utf-8")


_COMMANDED = _family("commanded") | {name: _example(name) for name in _EXAMPLES}
_SWITCHED, _PROGRAMMED = _family("switched"), _family("programmed")
_PLAIN = _family("plain")
TEXTS = _PLAIN | _COMMANDED | _SWITCHED | _PROGRAMMED
NAMES = tuple(TEXTS)
SEVERAL = {
    "printer": _example("printer"),
    "both heaters on one timer": _example("printer")
    .replace("pin: D10, frequency: 30 Hz", "pin: D22, frequency: 30 Hz")
    .replace("pin: D8, frequency: 30 Hz", "pin: D23, frequency: 20 Hz"),
    "barrel": _example("barrel"),
}
"""Of two loops."""
HOSTED = (*_COMMANDED, "held_by_host")
PROGRAMMED = tuple(name for name, text in _PROGRAMMED.items() if "programs:" in text)
BY_MASTER = tuple(name for name, text in _SWITCHED.items() if "modbus" in text)
BY_KEYS = tuple(name for name, text in _PLAIN.items() if "lcd_keypad" in text)
SWITCHED = (*BY_MASTER, *BY_KEYS, *_PROGRAMMED)
COMMANDED = (*HOSTED, *SWITCHED)
SWITCHING = tuple(_SWITCHED)


def in_other_order(text: str) -> str:
    """The same specification with its loops the other way round."""
    spec = yaml.load(text, yaml.BaseLoader)  # noqa: S506 - everything is text
    return _text({**spec, "loops": dict(reversed(spec["loops"].items()))})


@cache
def spec_of(name: str) -> Spec:
    return load_text(TEXTS[name], f"{name}.yaml")


def is_adjustable(name: str) -> bool:
    """Tell whether the operator may lower the critical temperature of the one loop."""
    ((_, loop),) = spec_of(name).controller.loops.items()
    return loop.protection.maximum_adjustable
