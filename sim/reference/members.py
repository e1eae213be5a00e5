"""Members of the control state: what a step leaves behind, by name and width."""

from typing import Any

Member = tuple[str, str]
"""Name as in docs/control.md and numpy type of its width in the firmware."""

Value = Any
"""An int or a numpy.float32, as the member's type says."""


def prefixed(prefix: str, members: tuple[Member, ...]) -> tuple[Member, ...]:
    """Name the members of a part of the state: `heating_steps` → `guard.heating_steps`."""
    return tuple((f"{prefix}.{name}", width) for name, width in members)
