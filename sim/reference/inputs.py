"""What goes into a control step of some loops beside reading and setpoint (docs/control.md)."""

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
    """Inputs of a step that not every loop has: orders, mostly."""

    mode: int = AUTOMATIC
    manual_percent: Single = ZERO
    """Duty that was asked for by hand."""
    gains: Gains | None = None
    """Needed by a tunable loop."""
    enabled: int = 1
    """Switch of a switched loop."""
    master_lost: bool = False
    """Whether a switched loop's master has been silent for too long."""
    current_raw: int = 0
    """The heater's current as its sensor reads it."""


NO_ORDERS = Orders()
