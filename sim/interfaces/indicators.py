"""LEDs as a person sees them: lit, blinking or dark."""

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.avr import Avr
from heatwright.spec import Board
from heatwright.spec import Indicators as Spec
from heatwright.spec.board.timers import TICK_S

Light = Literal["lit", "blinking", "dark", "unsteady"]

BLINK_S = 0.5
"""Bright and dark time of a blinking LED (docs/language.md, indicators)."""
LOOK_S = 2.0
"""Time needed to distinguish steady light from blinking: two whole blinks."""
REMEMBERED_S = 10.0


class Led:
    """One LED with its resistor.

    meaning -- the meaning in the spec; changes -- (time in s, whether it is bright from then on) in
    the ten seconds before the last change, and the change before those.
    """

    def __init__(self, avr: Avr, pin: str, active: str, meaning: str) -> None:
        self.meaning = meaning
        self.changes: list[tuple[float, bool]] = [(0.0, False)]
        self.pin = pin
        self._high = active == "high"
        self._clock_hz = avr.clock_hz
        # An LED and its resistor pull a floating pin to the level at which no current flows.
        avr.pins.pull(pin, "low" if self._high else "high")
        self._number = avr.pins.watch(pin)

    def feed(self, pins: NDArray[Any]) -> None:
        """Process the processor's pin changes."""
        mine = pins[pins["pin"] == self._number]
        for cycle, level in zip(mine["cycle"].tolist(), (mine["state"] & 1).tolist(), strict=True):
            bright = bool(level) == self._high
            if bright != self.changes[-1][1]:
                self.changes.append((cycle / self._clock_hz, bright))
        self._forget()

    def _forget(self) -> None:
        oldest_s = self.changes[-1][0] - REMEMBERED_S
        keep = next(at for at, change in enumerate(self.changes) if change[0] >= oldest_s)
        del self.changes[: max(0, keep - 1)]

    def light(self, now_s: float) -> Light:
        """Return what the LED has shown in the two seconds before a time.

        Blinking is bright and dark for half a second each, within a tick; any other change is
        unsteady.
        """
        begin_s = now_s - LOOK_S
        inside = [each for each in self.changes if begin_s < each[0] <= now_s]
        before = [bright for at_s, bright in self.changes if at_s <= begin_s]
        if not inside:
            return "lit" if before and before[-1] else "dark"
        phases_s = np.diff([at_s for at_s, _ in inside])
        ends_s = (inside[0][0] - begin_s, now_s - inside[-1][0])
        # LEDs are switched once a tick: a phase may be one tick longer or shorter.
        even = bool((np.abs(phases_s - BLINK_S) <= TICK_S).all())
        return "blinking" if even and max(ends_s) <= BLINK_S + TICK_S else "unsteady"


class Indicators:
    """The LEDs of a loop; leds -- by their pins' names in the spec."""

    complaints: tuple[str, ...] = ()

    def __init__(self, avr: Avr, board: Board, interface: Spec) -> None:
        self._avr = avr
        self.leds: Mapping[str, Led] = {
            pin: Led(avr, board.pins[pin].port_name, interface.active, meaning)
            for pin, meaning in interface.leds.items()
        }

    def feed(self, pins: NDArray[Any], sent: NDArray[Any]) -> None:
        """Process the processor's pin changes."""
        del sent
        if not len(pins):
            return
        for led in self.leds.values():
            led.feed(pins)

    def lights(self) -> dict[str, Light]:
        """Return what the LED of each meaning has shown in the last two seconds.

        Two LEDs of one meaning that differ count as unsteady. All pin changes up to now must have
        been fed.
        """
        shown: dict[str, Light] = {}
        for led in self.leds.values():
            light = led.light(self._avr.time_s)
            same = shown.setdefault(led.meaning, light) == light
            shown[led.meaning] = light if same else "unsteady"
        return shown


def attach(avr: Avr, board: Board, interface: Spec) -> Indicators:
    """Connect the LEDs to their pins."""
    return Indicators(avr, board, interface)
