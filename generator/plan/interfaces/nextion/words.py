"""The words that the touch display shows, in the order of their numbers."""

from heatwright.spec import RULES, Controller, facts_of

_OFF = (
    "off",
    "finished",
    "stopped",
    "stopped by a fault",
    "interrupted: too far off",
    "power was cut: unreadable",
)
"""Words while the loop is off, by `program.ended`."""
_RUNNING = ("runs", "held back", "waits for temperature", "waits for the operator")
"""Words for a running program, by `program.waiting`."""

_KINDS = ("", "time", "K/h", "fast", "hold", "until")
"""Words by the kind of a segment."""


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
    """Words by fault code, from 1 on; just the code if this controller does not have the rule."""
    known = {rule.code: f" {rule.display}" for rule in facts_of(controller).rules}
    return [f"E{code:02d}{known.get(code, '')}" for code in range(1, max(RULES) + 1)]


def _warnings(controller: Controller) -> tuple[str, ...]:
    """Words for the warning of each monitor, in the order of the monitors' numbers."""
    return tuple(f"warm: {name}" for name in controller.monitors)
