"""What goes into a control step of some loops beside reading and setpoint (docs/control.md)."""

from collections.abc import Mapping
from types import MappingProxyType
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


class Limits(NamedTuple):
    """Limits of a PID loop that a host may narrow, %."""

    integral_minimum: Single
    integral_maximum: Single
    output_maximum: Single


class Orders(NamedTuple):
    """Inputs of a step that not every loop has: orders, mostly."""

    mode: int = AUTOMATIC
    manual_percent: Single = ZERO
    """Duty that was asked for by hand."""
    gains: Gains | None = None
    """Needed by a tunable loop."""
    limits: Limits | None = None
    """Needed by a tunable loop whose limits are adjustable."""
    enabled: int = 1
    """Switch of a switched loop."""
    master_lost: bool = False
    """Whether the loop's master, or its host, has been silent for too long."""
    current_raw: int = 0
    """The heater's current as its sensor reads it."""
    program: tuple[int, int] = (0, 0)
    """Order to the program that waits to be taken, and its argument; (0, 0): none."""
    maximum_c: Single | None = None
    """The operator's critical temperature; needed where it is adjustable."""
    watch_fault: int = 0
    """What the watch of the safety relay, of a fan, or of the machine's inputs, has found."""
    paused: int = 0
    """Whether an input of the machine keeps it from being heated."""
    numbers: Mapping[str, Single] = MappingProxyType({})
    """By field of the algorithm, what keys have set; needed where they can."""
    monitors: Mapping[str, tuple[int, int]] = MappingProxyType({})
    """By monitor that is judged in the step: its reading's status and raw number."""


NO_ORDERS = Orders()
