"""A fan with a tachometer: simulated in C, with faults set from Python."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from heatwright.sim.native.relay import Wire
from heatwright.sim.native.shim import load

if TYPE_CHECKING:
    from heatwright.sim.avr import Avr


class Fan:
    """A motor on a pin, and on another pin an open collector that pulses to ground."""

    def __init__(  # noqa: PLR0913 - all properties of a fan
        self, avr: Avr, motor: str, line: str, *, active_high: bool, full_hz: float, lag_s: float
    ) -> None:
        """Connect the fan to its pins.

        full_hz -- pulses in a second at full speed; lag_s -- time constant of the speed. Raises
        ValueError: the processor has no such pin, or too many fans.
        """
        self._lib, self._clock_hz = load().lib, avr.clock_hz
        avr.pins.pull(motor, "low" if active_high else "high")
        pins = avr.pins.watch(motor), avr.pins.watch(line, logged=False)
        speeds = full_hz / avr.clock_hz, lag_s * avr.clock_hz
        self._fan: Any = self._lib.hw_fan_new(avr.pointer, pins[0], active_high, pins[1], *speeds)
        if not self._fan:
            raise ValueError("There are too many fans on this processor, or it lacks a pin.")

    def fail(
        self,
        pace: float = 1.0,
        noise_hz: float = 0.0,
        low_share: float = 0.5,
        wire: Wire = Wire.SOUND,
    ) -> None:
        """Set the fan's faults from now on; without arguments it is sound.

        pace -- share of its full speed: a fall is immediate, a rise has the time constant;
        noise_hz -- pulses per second on its line in place of its own, 0: its own; low_share --
        share of each pulse in which the line is low.
        """
        self._lib.hw_fan_fail(self._fan, pace, noise_hz / self._clock_hz, low_share, int(wire))

    @property
    def pulses_hz(self) -> float:
        """Pulses per second at the present speed, whatever is on the line."""
        return float(self._lib.hw_fan_speed(self._fan)) * self._clock_hz
