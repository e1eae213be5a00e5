"""Parse one line of a log: numbers, labels, clock times."""

import math
import re
from datetime import datetime
from typing import NamedTuple

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?"
_PLAIN = re.compile(_NUMBER)
_LABELLED = re.compile(rf"([A-Za-z_@][\w@.]*(?: ?[\[(][^\])]{{1,8}}[\])])?)\s*[:=]\s*({_NUMBER})")
_TARGET = re.compile(rf"(?:^|\s)([TBC]\d?):{_NUMBER} ?/({_NUMBER})")
_CLOCK = re.compile(r"(\d{1,2}):(\d{2}):(\d{2}(?:[.,]\d+)?)")
_STAMPED = re.compile(
    r"\[?(\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d(?:[.,]\d+)?(?:Z|[-+]\d\d:?\d\d)?"
    r"|\d{1,2}:\d\d:\d\d(?:[.,]\d+)?)\]?\s*(?:->|[:|])?\s+(?=\S)"
)
_MISSING = {"", "nan", "inf", "-inf", "+inf", "-nan", "null", "none", "na", "n/a", "-"}


class Dialect(NamedTuple):
    """The delimiter of the fields of a line, and the decimal mark."""

    delimiter: str | None
    """What separates the fields; None: blanks."""
    decimal: str


DIALECTS = (
    Dialect(",", "."),
    Dialect(";", "."),
    Dialect(";", ","),
    Dialect("\t", "."),
    Dialect("\t", ","),
    Dialect(None, "."),
    Dialect(None, ","),
)
"""All dialects, in order of preference if several fit."""


def unstamped(line: str) -> tuple[float | None, str]:
    """Split off the clock time (s) that a terminal program puts before a line."""
    found = _STAMPED.match(line)
    if found is None:
        return None, line
    return clock(found[1]), line[found.end() :]


def fields(line: str, dialect: Dialect) -> list[str]:
    """Split a line into fields; `$1.00 2.00;` of Serial Port Plotter gives 1.00 and 2.00."""
    bare = line.strip()
    if bare.startswith("$"):
        bare = bare[1:].rstrip(";").strip()
    return [field.strip().strip('"') for field in bare.split(dialect.delimiter)]


def labelled(line: str) -> dict[str, float]:
    """Return the numbers of a line with labels, in the format of the Arduino IDE's plotter.

    For example `temperature:20.5,duty:100`, or `T:201.3 /200.0 @:127` from a 3D printer: its target
    is named `T target`, and targets come after all other numbers.
    """
    found = {name: float(text) for name, text in _LABELLED.findall(line)}
    return found | {f"{name} target": float(text) for name, text in _TARGET.findall(line)}


def value(text: str, dialect: Dialect) -> float | None:
    """Read a field: a number, a time of day or date in s; NaN for a gap, None for anything else."""
    if text.lower() in _MISSING:
        return math.nan
    plain = text.replace(",", ".") if dialect.decimal == "," else text
    if _PLAIN.fullmatch(plain):
        return float(plain)
    return clock(text)


def clock(text: str) -> float | None:
    """Read a time of day, or a date with one (ISO 8601), s; None if it is none."""
    found = _CLOCK.fullmatch(text)
    if found:
        hours, minutes, seconds = found.groups()
        return int(hours) * 3600.0 + int(minutes) * 60.0 + float(seconds.replace(",", "."))
    if "-" not in text[1:] or ":" not in text:
        return None
    try:
        moment = datetime.fromisoformat(text.replace(",", "."))
    except ValueError:
        return None
    return moment.replace(tzinfo=None).timestamp() if moment.tzinfo is None else moment.timestamp()
