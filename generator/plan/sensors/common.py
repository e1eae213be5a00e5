"""What the plans of all sensors are told."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class UseOfSensor:
    """What the firmware does with a sensor."""

    period_s: float
    """Shortest period of the loops that read it, s."""
    timer: int | None
    """Number of the timer that is its own; None for a sensor that needs none."""
