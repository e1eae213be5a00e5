"""The Arduino LCD keypad shield: a display of 16 x 2 characters and five keys."""

from collections.abc import Iterable, Iterator
from typing import Any

from numpy.typing import NDArray

from heatwright.sim.avr import Avr
from heatwright.sim.interfaces.lcd import Lcd
from heatwright.sim.interfaces.lcd_keypad.keypad import Fingers, Keypad
from heatwright.spec import Board
from heatwright.spec import LcdKeypad as Spec

LCD_PINS = ("D8", "D9", "D4", "D5", "D6", "D7")
"""RS, E, D4..D7 of the display, on the board's pins."""
KEYPAD_PIN = "A0"


class LcdKeypad:
    """The shield on a board. lcd -- its display; keypad -- its keys; fingers -- press the keys."""

    def __init__(self, avr: Avr, board: Board) -> None:
        self._avr = avr
        pins = [board.pins[name].port_name for name in LCD_PINS]
        for pin in pins:
            avr.pins.watch(pin)
        self.lcd = Lcd(pins, avr.clock_hz)
        channel = board.pins[KEYPAD_PIN].adc
        if channel is None:
            raise ValueError(f"Pin {KEYPAD_PIN} of {board.name} is no analog input.")
        self.keypad = Keypad(avr, channel)
        self.fingers = Fingers(self.keypad, avr.clock_hz)

    @property
    def text(self) -> tuple[str, str]:
        """The rows of its display."""
        return self.lcd.text

    @property
    def wake_cycle(self) -> int | None:
        """The cycle of the next press, release or bounce of a key; None: there is none."""
        wakes = (self.fingers.wake_cycle, self.keypad.wake_cycle)
        return min((wake for wake in wakes if wake is not None), default=None)

    def play(self, keys: Iterable[str]) -> None:
        """Press keys one after the other, from now on."""
        self.fingers.play(keys, self._avr.cycle)

    @property
    def complaints(self) -> Iterator[str]:
        """Yield the violations of the display's time limits."""
        for limit, count in self.lcd.violations.items():
            yield f"display: {limit} was below the data sheet {count} times"

    def feed(self, pins: NDArray[Any], sent: NDArray[Any]) -> None:
        """Process the processor's pin changes, and move the keys."""
        del sent
        self.lcd.feed(pins)
        self.keypad.advance(self._avr.cycle)
        self.fingers.move(self._avr.cycle)


def attach(avr: Avr, board: Board, interface: Spec) -> LcdKeypad:
    """Put the shield on the board."""
    del interface
    return LcdKeypad(avr, board)
