"""Inputs of a control step in addition to reading and setpoint (docs/control.md)."""

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
    """Inputs of a step that not every loop has; most are commands."""

    mode: int = AUTOMATIC
    manual_percent: Single = ZERO
    """The manual duty."""
    gains: Gains | None = None
    """The gains of the PID; needed by a tunable loop."""
    limits: Limits | None = None
    """The limits of the PID; needed by a tunable loop whose limits are adjustable."""
    enabled: int = 1
    """Whether a switched loop is switched on."""
    master_lost: bool = False
    """Whether the loop's master, or its host, has been silent for too long."""
    current_raw: int = 0
    """The raw reading of the heater's current."""
    program: tuple[int, int] = (0, 0)
    """The waiting command to the program, and its argument; (0, 0): none."""
    maximum_c: Single | None = None
    """The critical temperature that the operator has set; needed if it is adjustable."""
    watch_fault: int = 0
    """Code of the fault found at the safety relay, a fan, or the machine's inputs; 0: none."""
    paused: int = 0
    """Whether an input of the machine pauses the heat."""
    numbers: Mapping[str, Single] = MappingProxyType({})
    """By field of the algorithm, the numbers that the keypad has set; needed if the keypad can."""
    monitors: Mapping[str, tuple[int, int]] = MappingProxyType({})
    """By monitor that is checked in the step: status and raw number of its reading."""


NO_ORDERS = Orders()
