"""Stored programs as the firmware keeps them (docs/control.md, "Programs")."""

from typing import Any, NamedTuple

import numpy as np

from heatwright.sim.reference.numbers import Single
from heatwright.spec import Program, Segment

OVER, RATE, FAST, HOLD, UNTIL = range(1, 6)
"""Kinds of segments."""
KINDS = {"over": OVER, "rate": RATE, "fast": FAST, "hold": HOLD, "until": UNTIL}

TENTH = Single(0.1)


class Part(NamedTuple):
    """One segment of a program."""

    kind: int
    to_dc: int = 0
    """Target, 0.1 °C."""
    amount: int = 0
    """Time, s, or rate, 0.1 K/h."""

    @property
    def target_c(self) -> Single | None:
        """The temperature at its end, °C; None if it has no target of its own."""
        return Single(self.to_dc) * TENTH if self.kind in (OVER, RATE, FAST) else None


Copy = tuple[Part, ...]
"""A program: its segments in order."""
Cell = tuple[int, list[Part]]
"""A program in a log: how many segments it has, and a list of them padded to equal length."""


def copy_of(program: Program) -> Copy:
    """Return a program of the spec as the firmware stores it."""
    return tuple(_part(segment) for segment in program.segments)


def column_of(points: int) -> list[tuple[Any, ...]]:
    """Return the column `loaded` of a log for this number of segments; no column for 0."""
    part = [("kind", "u1"), ("to_dc", "<i2"), ("amount", "<u4")]
    loaded = [("segments", "u1"), ("segment", part, (points,))]
    return [("loaded", loaded)] if points else []


def cell_of(copy: Copy, points: int) -> Cell:
    """Return the cell of that column for a program."""
    return len(copy), [*copy, *[Part(0)] * (points - len(copy))]


def from_cell(loaded: np.void) -> Copy:
    """Return the program in a cell of that column."""
    parts = loaded["segment"][: int(loaded["segments"])]
    return tuple(Part(int(part["kind"]), int(part["to_dc"]), int(part["amount"])) for part in parts)


def _part(segment: Segment) -> Part:
    amount = segment.over_s or segment.hold_s or 10 * (segment.at_k_per_h or 0.0)
    return Part(KINDS[segment.kind], round(10 * (segment.to_c or 0.0)), round(amount))
