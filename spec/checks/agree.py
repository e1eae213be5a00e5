"""Several checks may report one key: the reported advice must satisfy all of them."""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Callable, Iterable
from functools import partial
from typing import NamedTuple

from pydantic_core import PydanticCustomError

from heatwright.spec import units
from heatwright.spec.checks.finding import Finding
from heatwright.spec.problems import Path
from heatwright.spec.quantity import parse
from heatwright.spec.units import Dimension

_ADVICE = re.compile(
    r"Use (at least |more than |at most |)(-?\d[^,;]*?)( to (-?\d[^,;]*?))?([,;] .*)?"
)
_DIMENSIONS = [value for value in vars(units).values() if isinstance(value, Dimension)]


class _Advice(NamedTuple):
    """The range of numbers that a remedy advises, in a base unit."""

    low: float
    high: float
    words: str
    """The advice without its alternatives: `Use at least 2 K/s`."""
    rest: str

    @property
    def nearest(self) -> float:
        """The number within the advice that a user most likely writes: its nearest end."""
        return self.low if math.isfinite(self.low) else self.high

    def allows(self, other: _Advice) -> bool:
        """Return whether a user who follows the other advice satisfies this one, too.

        A single value always does: it is the nearest multiple of a step, and others are as good.
        """
        return self.low == self.high or self.low <= other.nearest <= self.high


def agreed(findings: Iterable[Finding]) -> list[Finding]:
    """Return the findings, each with advice that satisfies all findings at its key, if any does."""
    found = list(findings)
    advices: dict[Path, list[_Advice]] = defaultdict(list)
    for finding in found:
        advices[finding.path] += _read(finding.remedy)
    return [
        finding._replace(remedy=_agreed(finding.remedy, advices[finding.path])) for finding in found
    ]


def _agreed(remedy: str, advices: list[_Advice]) -> str:
    for own in _read(remedy):
        best = next((each for each in advices if all(o.allows(each) for o in advices)), own)
        return f"{best.words}{own.rest}"
    return remedy


def _read(remedy: str) -> list[_Advice]:
    """Parse a remedy; empty if it advises no number."""
    match = _ADVICE.fullmatch(remedy)
    if match is None:
        return []
    kind, first, _, second, rest = match.groups()
    values = _values([first, *([second] if second else [])])
    if not values:
        return []
    low = -math.inf if kind == "at most " else values[0]
    low = math.nextafter(low, math.inf) if kind == "more than " else low
    high = math.inf if kind in {"at least ", "more than "} else values[-1]
    return [_Advice(low, high, remedy.removesuffix(rest or ""), rest or "")]


def _values(texts: list[str]) -> list[float]:
    """Parse quantities of one dimension; return an empty list if the texts are not that."""
    readers: list[Callable[[str], float]] = [float]
    for read in readers + [partial(parse, dimension=each) for each in _DIMENSIONS]:
        try:
            return [read(text) for text in texts]
        except (ValueError, PydanticCustomError):
            continue
    return []
