"""A fan with a tachometer: its course in C, what is broken from Python."""

from __future__ import annotations

from typing import Any

from heatwright.sim.native.hw import Hw
from heatwright.sim.native.relay import Wire


class Fan:
    """A motor at a pin, and pulses to ground, by an open collector, at another."""

    def __init__(  # noqa: PLR0913 - a fan, said once
        self,
        hw: Hw,
        motor: int,
        line: int,
        *,
        active_high: bool,
        full_hz: float,
        lag_s: float,
    ) -> None:
        """Wire it to pins, by their numbers.

        full_hz -- pulses in a second at full speed; lag_s -- time constant of the speed.

        Raises ValueError when the processor has no such pin, or too many fans.
        """
        self._lib, self._clock_hz = hw.lib, hw.clock_hz
        speeds = full_hz / hw.clock_hz, lag_s * hw.clock_hz
        self._fan: Any = hw.lib.hw_fan_new(hw.pointer, motor, active_high, line, *speeds)
        if not self._fan:
            raise ValueError("There are too many fans on this processor, or no such pins.")

    def fail(
        self,
        pace: float = 1.0,
        noise_hz: float = 0.0,
        low_share: float = 0.5,
        wire: Wire = Wire.SOUND,
    ) -> None:
        """Break it so from now on, or mend it.

        pace -- full speed, as a share of its own; it falls to it at once, and rises as it starts.
        noise_hz -- pulses in a second that are on its line instead; 0: its own.
        low_share -- of each pulse.
        """
        self._lib.hw_fan_fail(self._fan, pace, noise_hz / self._clock_hz, low_share, int(wire))

    @property
    def pulses_hz(self) -> float:
        """Pulses in a second at its speed now, whatever is on the line."""
        return float(self._lib.hw_fan_speed(self._fan)) * self._clock_hz
