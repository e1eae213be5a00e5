"""Members of the control state after a step: name, width and value."""

from collections.abc import Callable
from functools import cache
from operator import attrgetter
from typing import Any

Member = tuple[str, str]
"""Name as in docs/control.md and numpy type of its width in the firmware."""

Value = Any
"""An int or a numpy.float32, by the member's type."""


class Kept:
    """A part of the control state."""

    members: tuple[Member, ...]

    def keep(self, *shown: tuple[str, str, str]) -> None:
        """Define the members: name, width, and the attribute that has the value."""
        self.members = tuple((name, width) for name, width, _ in shown)
        self._read = _reader(tuple(attribute for _, _, attribute in shown))

    def values(self) -> tuple[Value, ...]:
        """Return the values of `members`."""
        return self._read(self)


@cache
def _reader(attributes: tuple[str, ...]) -> Callable[[object], tuple[Value, ...]]:
    """Return a reader of attributes; for a single one `attrgetter` would not return a tuple."""
    if len(attributes) > 1:
        return attrgetter(*attributes)
    return lambda of: tuple(getattr(of, name) for name in attributes)


def prefixed(prefix: str, members: tuple[Member, ...]) -> tuple[Member, ...]:
    """Put a prefix before the names of members: `heating_steps` → `guard.heating_steps`."""
    return tuple((f"{prefix}.{name}", width) for name, width in members)
