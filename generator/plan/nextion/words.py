"""The words that the touch display shows, in the order of their numbers."""

from __future__ import annotations

from heatwright.spec import Controller
from heatwright.spec.breakable import rules_of
from heatwright.spec.rules import RULES

_OFF = (
    "off",
    "finished",
    "stopped",
    "stopped by a fault",
    "interrupted: too far off",
    "power was cut: unreadable",
)
"""By `program.ended`."""
_RUNNING = ("runs", "held back", "waits for temperature", "waits for the operator")
"""By `program.waiting`."""

_KINDS = ("", "time", "K/h", "fast", "hold", "until")
"""By the kind of a segment."""


def words(controller: Controller) -> tuple[list[str], dict[str, int]]:
    """Return all words, and the numbers of those that have a name in C."""
    groups = {
        "OFF": _OFF,
        "ON": ("on",),
        "BY_HAND": ("by hand",),
        "RUNNING": _RUNNING,
        "PAUSED": ("paused",),
        "RETURNING": ("returns to its setpoint",),
        "RESTORING": ("power was cut: looks around",),
        "INTERRUPTED": ("paused by a fault",),
        "KINDS": _KINDS,
        "FAULTS": ("", *_faults(controller)),
        **({"WARNINGS": _warnings(controller)} if controller.monitors else {}),
    }
    found: list[str] = []
    first: dict[str, int] = {}
    for name, texts in groups.items():
        first[f"WORD_OF_{name}"] = len(found)
        found += texts
    return found, first


def _faults(controller: Controller) -> list[str]:
    """Words by fault code, from 1 on; only the code if this controller does not have the rule."""
    known = {rule.code: f" {rule.display}" for rule in rules_of(controller)}
    return [f"E{code:02d}{known.get(code, '')}" for code in range(1, max(RULES) + 1)]


def _warnings(controller: Controller) -> tuple[str, ...]:
    """Words by the monitor's number, cut to the line beside its name."""
    return tuple(f"warm: {name}" for name in controller.monitors)
