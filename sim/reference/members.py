"""Members of the control state after a step, by name and width."""

from typing import Any

Member = tuple[str, str]
"""Name as in docs/control.md and numpy type of its width in the firmware."""

Value = Any
"""An int or a numpy.float32, by the member's type."""


def prefixed(prefix: str, members: tuple[Member, ...]) -> tuple[Member, ...]:
    """Put a prefix before the names of members: `heating_steps` → `guard.heating_steps`."""
    return tuple((f"{prefix}.{name}", width) for name, width in members)
