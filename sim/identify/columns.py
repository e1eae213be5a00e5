"""The meaning of a log's columns: by the names in its header, or by the user's options."""

import re
from collections.abc import Callable, Sequence
from typing import NamedTuple

from heatwright.sim.identify.log import STAMP, Unusable

ROLES = ("time", "temperature", "duty", "power")
OTHERS = re.compile(r"set.?point|target|ambient|fault|error", re.IGNORECASE)
"""Names of columns with the unit of a temperature or a duty that are something else."""

_UNIT = re.compile(r"^(.*?)\s*[\[(]([^\])]*)[\])]$")
_ENDINGS = (("_percent", "%"), ("_ms", "ms"), ("_c", "°C"), ("_s", "s"), ("_w", "W"))


class Column(NamedTuple):
    """A column of the log, and its unit if the log names it."""

    place: int
    """Number of the column, from 0."""
    unit: str
    """The unit, from the column's name or the user; empty: unknown."""


class Roles(NamedTuple):
    """The columns of a log that are used."""

    temperature: Column
    time: Column | None = None
    duty: Column | None = None
    power: Column | None = None


Look = Callable[[str, str], bool]


def _like(pattern: str) -> Look:
    found = re.compile(pattern, re.IGNORECASE)
    return lambda name, _: found.search(name) is not None


def _in(*units: str) -> Look:
    return lambda _, unit: unit in units


PREFERENCES: dict[str, tuple[Look, ...]] = {
    "time": (
        _like(r"^(time|timestamp|elapsed|seconds?|millis|ms|date.?time|date)(_m?s)?$"),
        _like(r"(?-i:^t$)|time"),
    ),
    "temperature": (
        _like(r"^(\w+\.)?temp(erature)?(_c)?$"),
        _like(r"temp"),
        _like(r"^T0?$"),
        _in("°C", "C", "degC", "°F", "F", "K"),
    ),
    "duty": (
        _like(r"^(\w+\.)?duty(_percent)?$"),
        _like(r"duty"),
        _like(r"pwm|heater|output"),
        _like(r"^@$"),
        _in("%"),
    ),
    "power": (_in("W", "kW", "mW"), _like(r"power|watt")),
}
"""How each role is recognised, from the surest sign to the weakest."""


def with_unit(title: str) -> tuple[str, str]:
    """Split a title into name and unit: `air.duty_percent [%]`, `time (ms)`, `temp_c`."""
    found = _UNIT.match(title)
    if found:
        return found[1], found[2].strip()
    for ending, unit in _ENDINGS:
        if title.lower().endswith(ending):
            return title, unit
    return title, "ms" if title.lower() in {"ms", "millis"} else ""


def named_roles(names: Sequence[str], loop: str = "") -> Roles:
    """Find the columns by the names in the log's header; if several fit, the loop's are chosen.

    Raises Unusable: there are no names, or they are not clear.
    """
    if not names:
        raise Unusable(
            "does not name its columns; name them, such as --columns time,temperature,duty"
        )
    found = {role: _one(role, names, loop) for role in ROLES}
    stamps = [place for place, name in enumerate(names) if name == STAMP]
    if stamps:
        found["time"] = Column(stamps[0], "s")
    return _checked(found, names)


def _one(role: str, names: Sequence[str], loop: str) -> Column | None:
    titles = [with_unit(name) for name in names]
    for fits in PREFERENCES[role]:
        places = [
            place
            for place, (name, unit) in enumerate(titles)
            if fits(name, unit) and not OTHERS.search(name)
        ]
        own = [place for place in places if loop and names[place].startswith(f"{loop}.")]
        places = own or places
        if len(places) == 1:
            return Column(places[0], titles[places[0]][1])
        if places and role != "power":
            shown = ", ".join(names[place] for place in places)
            raise Unusable(
                f"has several columns that could be the {role}: {shown}. "
                f"Say which, such as --columns '{role}={names[places[0]]}'"
            )
    return None


def chosen_roles(
    text: str, names: Sequence[str], width: int, *, stamped: bool, loop: str = ""
) -> Roles:
    """Parse the user's option: roles in the order of the columns, or `role=name or number`.

    `time[ms],temperature,-,duty`, `temperature=air [°C],duty=5`. Roles not named are looked for in
    the header, if there is one and only `role=…` is used.
    """
    entries = [entry.strip() for entry in text.split(",")]
    found: dict[str, Column | None] = dict.fromkeys(ROLES)
    by_name = all("=" in entry for entry in entries)
    for place, entry in enumerate(entries):
        role, column = _entry(entry, place, names, width)
        if role is not None:
            found[role] = column
    if by_name and names:
        found |= {role: _one(role, names, loop) for role, column in found.items() if column is None}
    if stamped and found["time"] is None:
        found["time"] = Column(width - 1, "s")
    return _checked(found, names)


def _entry(
    entry: str, place: int, names: Sequence[str], width: int
) -> tuple[str | None, Column | None]:
    wanted, given, where = entry.partition("=")
    role, unit = with_unit(wanted.strip())
    if not given and role in {"", "-"}:
        return None, None
    if role not in ROLES:
        raise Unusable(
            f"cannot have a column {role}; write {', '.join(ROLES)}, or - to ignore a column"
        )
    if not given:
        if place >= width:
            raise Unusable(f"has {width} columns; --columns names {place + 1}")
        return role, Column(place, unit or _unit(names, place))
    found = _place(where.strip(), names, width)
    return role, Column(found, unit or _unit(names, found))


def _place(where: str, names: Sequence[str], width: int) -> int:
    if where in names:
        return list(names).index(where)
    if where.isdecimal() and 1 <= int(where) <= width:
        return int(where) - 1
    able = f"; it has {', '.join(names)}" if names else f"; number them from 1 to {width}"
    raise Unusable(f"has no column {where}{able}")


def _unit(names: Sequence[str], place: int) -> str:
    return with_unit(names[place])[1] if names else ""


def _checked(found: dict[str, Column | None], names: Sequence[str]) -> Roles:
    shown = f" among {', '.join(names)}" if names else ""
    temperature = found["temperature"]
    if temperature is None:
        raise Unusable(f"has no column of temperature{shown}; name it: --columns temperature=…")
    if found["duty"] is None and found["power"] is None:
        raise Unusable(
            f"has no column of duty or power{shown}; name it: --columns duty=…, or write one: 0 in "
            "the lines before the heater was on, 100 from there on"
        )
    return Roles(temperature, found["time"], found["duty"], found["power"])
