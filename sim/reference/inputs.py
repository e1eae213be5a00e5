"""What a host may order of a loop, as the next control step takes it over (docs/control.md)."""

from typing import NamedTuple

from heatwright.sim.reference.numbers import ZERO, Single

AUTOMATIC, MANUAL, TUNING = 0, 1, 2
"""Modes of a commanded loop."""


class Gains(NamedTuple):
    """Gains of a PID loop."""

    kp: Single
    """%/K."""
    ki: Single
    """%/(K·s)."""
    kd: Single
    """%·s/K."""


class Orders(NamedTuple):
    """Inputs of a step that only a commanded loop has."""

    mode: int = AUTOMATIC
    manual_percent: Single = ZERO
    """Duty that was asked for by hand."""
    gains: Gains | None = None
    """Needed by a tunable loop."""


NO_ORDERS = Orders()
