"""Composes a spec to start from: a machine's numbers, a sensor, an output, an interface."""

import re
from functools import cache
from importlib.resources import files
from itertools import product
from typing import Any, NamedTuple

import yaml
from jinja2 import Environment, StrictUndefined

from heatwright.spec.boards import BOARDS

_COMMENT_COLUMN = 35
_UNITS = {"kp": "%/K", "ki": "%/(K·s)", "kd": "%·s/K"}


class Choice(NamedTuple):
    """What `init` makes a spec of; each value is a key in `machines.yaml` or `parts.yaml`."""

    machine: str
    board: str
    sensor: str
    output: str
    interface: str


@cache
def machines() -> dict[str, Any]:
    """Return the machines by name."""
    return dict(yaml.load(_text("machines.yaml"), yaml.CSafeLoader))


@cache
def parts() -> dict[str, Any]:
    """Return boards, sensors, outputs and interfaces, each by name."""
    return dict(yaml.load(_text("parts.yaml"), yaml.CSafeLoader))


def has_needs(board: str, part: dict[str, Any]) -> bool:
    """Return whether a board has what an output or an interface needs."""
    has = vars(BOARDS[board]) | {"timers": len(BOARDS[board].timers)}
    return all(has[key] >= least for key, least in part.get("needs", {}).items())


def choices() -> list[Choice]:
    """List all combinations that can be chosen; the first of each machine is the usual one."""
    return [
        Choice(name, board, sensor, output, interface)
        for name, machine in machines().items()
        for sensor, output, interface, board in product(
            machine["sensors"], machine["outputs"], machine["interfaces"], parts()["boards"]
        )
        if has_needs(board, parts()["outputs"][output])
        and has_needs(board, parts()["interfaces"][interface])
    ]


def narrowed(left: list[Choice], kind: str, name: str) -> list[Choice]:
    """Return the combinations with a given part; none if no combination has it."""
    return [each for each in left if getattr(each, kind) == name]


def names(left: list[Choice], kind: str) -> dict[str, str]:
    """Return the parts of a kind that can still be chosen, the usual first, with descriptions."""
    told = machines() if kind == "machine" else parts()[f"{kind}s"]
    return {
        name: told[name].get("about") or told[name].get("title", "")
        for name in dict.fromkeys(getattr(each, kind) for each in left)
    }


def composed(choice: Choice, name: str, file: str) -> str:
    """Return the text of the spec; name -- of the controller; file -- named in its comments."""
    machine = machines()[choice.machine]
    pins = parts()["boards"][choice.board]
    others = iter(pins["others"])
    sensors = iter(pins["sensors"])
    interface = parts()["interfaces"][choice.interface]
    output = parts()["outputs"][choice.output]
    sensor = parts()["sensors"][choice.sensor]
    loops = {
        loop: {
            **at,
            "heater": "heater" if len(machine["loops"]) == 1 else f"{loop}_heater",
            "pin": next(others),
            "sensor": _filled(
                sensor["text"], at=at, pins=[next(sensors) for _ in range(sensor["pins"])]
            ),
            "output": _filled(output["text"], at=at),
            "period": _period(max(at["period_ms"], sensor["period_ms"])),
            "algorithm": {"kind": output["algorithm"], **at[output["algorithm"]]},
            "initial": interface.get("initial", at["target"]),
        }
        for loop, at in machine["loops"].items()
    }
    first, numbers = next(iter(loops.items()))
    programs = first if choice.interface in machine.get("programs", ()) else ""
    if programs:
        numbers["algorithm"]["feed_forward"] = machine["feed_forward"]
    wires = {
        "fan": next(others) if "fan" in machine else "",
        "relay": next(others) if machine.get("relay") else "",
    }
    shown = _filled(interface["text"], loops=loops, loop=first, at=numbers, pins=[*others])
    order = "{at: 5 s, program: start 1}" if programs else interface["order"]
    orders = [_filled(order, loop=loop, at=at) for loop, at in loops.items()] if order else []
    text = _environment().from_string(_text("spec.yaml.j2")).render(
        choice._asdict() | wires,
        machine=machine,
        name=name,
        file=file,
        about={kind: parts()[f"{kind}s"][chosen]["about"]
               for kind, chosen in choice._asdict().items() if kind in ("sensor", "output")},
        loops=loops,
        programs=programs,
        starts=interface.get("starts", ""),
        watchdog="2 s" if numbers["period_ms"] >= 1000 else "1 s",
        interfaces=[shown],
        orders=orders,
        expect=numbers["expect"] if output["algorithm"] == "pid" else {},
        units=_UNITS,
    )  # fmt: skip
    return _aligned(text)


def _text(name: str) -> str:
    return files("heatwright.cli.starters").joinpath(name).read_text(encoding="utf-8")


@cache
def _environment() -> Environment:
    environment = Environment(
        autoescape=False,  # noqa: S701 - the text is YAML, not HTML
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["flow"] = _flow
    return environment


def _filled(text: str, **given: object) -> str:
    return _environment().from_string(text).render(given).rstrip("\n")


def _period(ms: int) -> str:
    return f"{ms} ms" if ms < 1000 else f"{ms / 1000:g} s"


def _flow(pairs: dict[str, object]) -> str:
    """Write a mapping on one line."""
    return "{" + ", ".join(f"{key}: {value}" for key, value in pairs.items()) + "}"


def _aligned(text: str) -> str:
    """Align the comments at the ends of lines."""
    return re.sub(
        r"^(.*\S) +# ",
        lambda found: f"{found[1]:<{_COMMENT_COLUMN - 2}}  # ",
        text,
        flags=re.MULTILINE,
    )
