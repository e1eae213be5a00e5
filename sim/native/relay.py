"""A relay's coil and contacts: simulated in C, with faults set from Python."""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING, Any

from heatwright.sim.native.shim import load

if TYPE_CHECKING:
    from heatwright.sim.avr import Avr


class Armature(IntEnum):
    """The state of the main contacts."""

    SOUND = 0
    WELDED = 1
    """The contacts stay closed, whatever the coil does."""
    DEAD = 2
    """The contacts stay open."""


class Wire(IntEnum):
    """The state of the wire of a mirror contact, an airflow contact or a tachometer."""

    SOUND = 0
    TORN = 1
    SHORTED = 2
    """The wire is shorted to ground."""


class Relay:
    """A relay with its coil on a pin, and its mirror contact to ground, if any, on another.

    pointer -- the relay in the shim.
    """

    def __init__(  # noqa: PLR0913 - all properties of a relay
        self,
        avr: Avr,
        coil: str,
        contact: str | None,
        *,
        active_high: bool,
        operate_s: float,
        release_s: float,
    ) -> None:
        """Connect the relay; its contacts follow the coil after these times, s.

        Raises ValueError: the processor has no such pin, or too many relays.
        """
        self._lib = load().lib
        avr.pins.pull(coil, "low" if active_high else "high")
        pins = avr.pins.watch(coil), -1 if contact is None else avr.pins.watch(contact)
        times = (round(seconds * avr.clock_hz) for seconds in (operate_s, release_s))
        self.pointer: Any = self._lib.hw_relay_new(
            avr.pointer, pins[0], active_high, pins[1], *times
        )
        if not self.pointer:
            raise ValueError("There are too many relays on this processor, or it lacks a pin.")

    def fail(self, armature: Armature, wire: Wire) -> None:
        """Set the faults of armature and wire from now on, or repair them."""
        self._lib.hw_relay_fail(self.pointer, int(armature), int(wire))

    @property
    def closed(self) -> bool:
        """Whether its main contacts conduct now."""
        return bool(self._lib.hw_relay_closed(self.pointer))

    @property
    def closed_cycles(self) -> int:
        """Cycles for which the main contacts have conducted."""
        return int(self._lib.hw_relay_closed_cycles(self.pointer))
