"""The user's actions at the bench, as a scenario that `simulate` can play."""

import json
from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from heatwright.cli.bench.parts.seat import BadOrder
from heatwright.spec import Event
from heatwright.spec.base import MOST_ENTRIES
from heatwright.spec.loading.translate import findings
from heatwright.spec.scenario.writes import AMOUNTS

LEAST_S = 1.0
"""Shortest time from the last event to the end of a scenario."""


class Unsaid(ValueError):
    """The scenario cannot be written; the text says why."""


class Recorded:
    """Events and remarks, in the order in which they came."""

    def __init__(self) -> None:
        self._lines: list[tuple[float, Mapping[str, Any] | str]] = []

    def event(self, at_s: float, what: Mapping[str, Any]) -> None:
        """Record an event of a scenario."""
        self._lines.append((at_s, what))

    def remark(self, at_s: float, text: str) -> None:
        """Record an action that a scenario cannot express, as a comment."""
        self._lines.append((at_s, text))

    def __len__(self) -> int:
        return len(self._lines)

    def text(self, name: str, ends_s: float) -> str:
        """Return the scenario file; ends_s -- its length.

        Raises Unsaid: it would have too many events.
        """
        lines = sorted(self._lines, key=lambda line: line[0])
        count = sum(not isinstance(what, str) for _, what in lines)
        if count >= MOST_ENTRIES:
            raise Unsaid(f"{count} events are too many: a scenario has at most {MOST_ENTRIES - 1}.")
        found = [
            f"# Recorded at the bench of {name}; a scenario cannot express the lines with #.",
            "scenario:",
        ]
        for at_s, what in lines:
            if isinstance(what, str):
                found.append(f"  # {at_s:.2f} s: {what}")
            else:
                found.append(f"  - {_written(at_s, what)}")
        last_s = max((at_s for at_s, _ in lines), default=0.0)
        found.append(f"  - {{for: {max(ends_s, last_s + LEAST_S):.2f} s}}")
        return "\n".join(found) + "\n"


def _written(at_s: float, what: Mapping[str, Any]) -> str:
    """Return one event in YAML's flow style; its texts are quoted as in JSON."""
    parts = [f"at: {at_s:.2f} s"]
    parts += [f"{key}: {json.dumps(value, ensure_ascii=False)}" for key, value in what.items()]
    return "{" + ", ".join(parts) + "}"


def said(event: Event) -> dict[str, Any]:
    """Return an event's keys and values as a spec writes them, without its time."""
    found: dict[str, Any] = {}
    if event.press is not None:
        found = {"press": event.press} | ({"times": event.times} if event.times > 1 else {})
        if event.held_s is not None:
            found["held"] = f"{event.held_s:g} s"
    if event.send is not None:
        found["send"] = event.send
    if event.extrude_mm_per_s is not None:
        found["extrude"] = f"{event.extrude_mm_per_s:g} mm/s"
    if event.write is not None:
        found["write"] = {each.name: with_unit(each.name, each.value) for each in event.write}
    if event.program is not None:
        found["program"] = f"{event.program.order} {event.program.number or ''}".rstrip()
    return found


def with_unit(name: str, value: Any) -> Any:
    """Return a value that a master writes, as in a spec: setpoint and duty have units."""
    what = name.rpartition(".")[2]
    if what in AMOUNTS and not isinstance(value, bool) and isinstance(value, int | float):
        return f"{value:g} {AMOUNTS[what].base}"
    return value


def in_words(what: Mapping[str, Any]) -> str:
    """Describe an event in a few words."""
    parts = []
    for key, value in what.items():
        if isinstance(value, Mapping):
            parts += [
                f"{name}: {json.dumps(each, ensure_ascii=False)}" for name, each in value.items()
            ]
        else:
            parts.append(f"{key} {value}")
    return ", ".join(parts)


def event_of(what: Mapping[str, Any]) -> Event:
    """Return the event with these keys. Raises BadOrder: a value is invalid; the text says why."""
    try:
        return Event.model_validate({"at": "0 s", **what})
    except ValidationError as error:
        _, reason, remedy = next(iter(findings(error, Event)))
        raise BadOrder(f"{reason}. {remedy}.") from None
