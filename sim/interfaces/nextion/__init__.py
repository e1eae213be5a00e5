"""A Nextion touch display on a board's serial port, and touches on it."""

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from heatwright.sim.avr import Avr
from heatwright.sim.interfaces.look import NEVER, Look
from heatwright.sim.interfaces.nextion.codes import END, Code
from heatwright.sim.interfaces.nextion.display import Display
from heatwright.sim.interfaces.nextion.line import Line
from heatwright.sim.interfaces.nextion.syntax import Value
from heatwright.spec import Board, Controller
from heatwright.spec import Nextion as Spec
from heatwright.spec.nextion import Page, display_pages
from heatwright.spec.scenario.program_orders import Order

START_S = 0.5
"""Time from power-on to its first message; until then it receives nothing."""
LOOK_S = 0.2
"""How often the display processes received bytes, s: it answers within this time."""
REMEMBERED = 10_000
"""Maximum number of instructions in the history."""
ORDERS: dict[Order, str] = {
    "start": "#8 {number};", "pause": "#9 0;", "resume": "#9 1;", "skip": "#18;",
    "jump": "#10 {number};", "stop": "#17;",
}  # fmt: skip
"""What the pages send for each command to the program; `jump` sends a segment's number less 1."""


@dataclass(frozen=True)
class Instruction:
    """An instruction from the board, and the time of its end, s."""

    time_s: float
    text: str


class Nextion:
    """The display at the end of a UART.

    history -- the latest instructions from the board; instructions -- their total number; said --
    the latest bytes that the display itself has sent; shortest_gap_s -- the shortest time from the
    first byte of an instruction to that of the next; display -- its state; line -- its line, with
    the display's own `baud`; is_plugged -- whether it is plugged in.
    """

    def __init__(self, avr: Avr, pages: Sequence[Page], baud: int, uart: int = 0) -> None:
        """Connect the display; it is powered together with the board."""
        self.display = Display(pages)
        self.line = Line(avr, uart, baud)
        self.set_speed(baud)
        self.history: deque[Instruction] = deque(maxlen=REMEMBERED)
        self.said: deque[bytes] = deque(maxlen=REMEMBERED)
        self.instructions = 0
        self.shortest_gap_s = float("inf")
        self._avr = avr
        self._began_s = float("-inf")
        self._begins_s: float | None = None
        self._seen_s = avr.time_s
        self.is_plugged = True
        self._heard = b""
        self._starts_s = avr.time_s + START_S
        self._look_cycles = round(LOOK_S * avr.clock_hz)

    def learn(self, controller: Controller) -> None:
        """Load the controller's pages, as from the editor's file."""
        baud = self.line.baud
        self.display = Display(display_pages(controller))
        self.set_speed(baud)

    def set_speed(self, baud: int) -> None:
        """Set the display's own baud rate, now and for each start."""
        self.display.memory.kept_baud = self.line.baud = baud
        self.display.memory.variables |= {"baud": baud, "bauds": baud}

    # -- operation -----------------------------------------------------------------------------

    def press(self, name: str) -> None:
        """Touch a component of the shown page. Raises LookupError."""
        self.display.press(name)
        self._answer()

    def touch(self, x: int, y: int) -> None:
        """Touch a point of the page, with or without a component."""
        self.display.touch(x, y)
        self._answer()

    def release(self) -> None:
        """Release the touch."""
        self.display.release()
        self._answer()

    def tap(self, *names: str) -> None:
        """Touch and release one component after the other. Raises LookupError."""
        for name in names:
            self.press(name)
            self.release()

    def send(self, data: str | bytes) -> None:
        """Send these bytes to the board at once."""
        if self.is_plugged:
            self.line.send(data.encode("latin-1") if isinstance(data, str) else data)

    def order(self, order: Order, number: int) -> None:
        """Give a command to the program; number -- the program to start, or the jump's segment."""
        self.send(ORDERS[order].format(number=number - (order == "jump")))

    def unplug(self) -> None:
        """Unplug the display: it is dark, and sends and receives nothing."""
        self.is_plugged = self.display.is_on = False
        self.line.cut()

    def plug(self) -> None:
        """Plug the display in again: it starts again."""
        self.is_plugged = True
        self._starts_s = self._avr.time_s + START_S

    # -- state ---------------------------------------------------------------------------------

    @property
    def picture(self) -> bytes:
        """The display's picture as a PNG."""
        from heatwright.sim.interfaces.nextion.screen import png  # noqa: PLC0415 - it imports matplotlib

        return png(self.display)

    @property
    def page(self) -> str:
        """The name of the shown page."""
        return self.display.page

    def value(self, attribute: str) -> Value:
        """Return an attribute: b0.txt of the shown page, or main.b0.txt."""
        return self.display.value(attribute)

    @property
    def errors(self) -> list[tuple[str, Code]]:
        """The refused instructions of the board, each with the reason."""
        return self.display.errors

    # -- time ----------------------------------------------------------------------------------

    @property
    def wake_cycle(self) -> int | None:
        """The cycle at which it next processes bytes; None while it is unplugged."""
        if not self.is_plugged:
            return None
        return (self._avr.cycle // self._look_cycles + 1) * self._look_cycles

    @property
    def is_busy(self) -> bool:
        """Whether it has bytes to process, or is still starting."""
        return self.is_plugged and (self.line.has_news or not self.display.is_on)

    @property
    def look(self) -> Look | None:
        """How C may look for bytes in its place; None if it also acts without bytes or a touch."""
        at = self.wake_cycle
        if at is None or self.is_busy:
            return None
        if any(part.values["en"] for part in self.display.memory.timers):
            return None
        return Look(at, self._look_cycles, NEVER)

    @property
    def complaints(self) -> Iterator[str]:
        """Yield refused instructions, and bytes with a wrong stop bit."""
        if self.errors:
            text, code = self.errors[0]
            reason = code.name.lower().replace("_", " ")
            yield f"display: it refused {len(self.errors)} instructions, first {text!r}: {reason}"
        if self.line.garbage:
            yield f"display: {self.line.garbage} bytes had no stop bit where one belongs"

    def feed(self, pins: NDArray[Any], sent: NDArray[Any]) -> None:
        """Receive what the UARTs have sent (UART_BYTE records)."""
        del pins
        data, cycles = self.line.hear(sent)
        self._heard = (self._heard + data)[-len(END) :]
        if not self.is_plugged or not self._has_started():
            return
        while (changed := self._take(data, cycles)) is not None:
            self.line.change(self.display.memory.variables["baud"], changed)
            data, cycles = self.line.hear(sent[:0])
        self._answer()

    def _take(self, data: bytes, cycles: list[int]) -> int | None:
        """Receive bytes; return the cycle at which one of them changed the line's baud rate."""
        now_s = self._avr.time_s
        self.display.pass_time(1000 * (now_s - self._seen_s))
        self._seen_s = now_s
        start = 0
        while start < len(data):
            if self._begins_s is None:
                self._begins_s = cycles[start] / self._avr.clock_hz
            end = data.find(END[:1], start) + 1 or len(data)
            if end - 1 > start and data.startswith(END, end - 1):
                end += len(END) - 1  # bytes before it may be the end of an earlier instruction
            for text in self.display.receive(data[start:end]):
                self._note(text, cycles[end - 1] / self._avr.clock_hz)
            if self.display.memory.variables["baud"] != self.line.baud:
                return cycles[end - 1]
            start = end
        return None

    def _has_started(self) -> bool:
        if not self.display.is_on and self._avr.time_s >= self._starts_s:
            self.display.start(midway=self._heard not in (b"", END))
            self.line.baud = self.display.memory.kept_baud
            self._seen_s = self._avr.time_s
            self._answer()
            return False  # the bytes up to now came while it was starting
        return self.display.is_on

    def _note(self, text: str, time_s: float) -> None:
        self.history.append(Instruction(time_s, text))
        self.instructions += 1
        if self._begins_s is not None:
            self.shortest_gap_s = min(self.shortest_gap_s, self._begins_s - self._began_s)
            self._began_s, self._begins_s = self._begins_s, None

    def _answer(self) -> None:
        if said := self.display.take():
            self.said.append(said)
            self.send(said)


def attach(avr: Avr, board: Board, interface: Spec) -> Nextion:
    """Connect the display to its UART; it has no pages yet."""
    return Nextion(avr, (), interface.baud, board.uarts[interface.port].number)
