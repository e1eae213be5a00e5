"""The words that the touch display shows, in the order of their numbers."""

from __future__ import annotations

from heatwright.generator.plan.core import rules
from heatwright.spec import Controller

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
    """Give all words, and the numbers of those that C calls by a name."""
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
    """By their codes, which have no gaps."""
    return [f"E{rule['code']:02d} {rule['display']}" for rule in rules(controller)]


def _warnings(controller: Controller) -> tuple[str, ...]:
    """By the monitors' numbers; a name leaves this much of the line."""
    return tuple(f"warm: {name}" for name in controller.monitors)
