"""A terminal on the line of the log."""

from typing import Any

from heatwright.cli.bench.parts.seat import Line, Live, Order, Seat, text_of
from heatwright.cli.bench.world import LiveWorld


class LogTerminal(Seat):
    """A person who reads the log."""

    kind = "serial_log"

    def __init__(self, *where: Any) -> None:
        super().__init__(*where)
        self._typed: list[Line] = []

    def about(self) -> dict[str, Any]:
        """Return the commands that can be typed."""
        return {"types": True, "hints": ["log", "help", "clear"]}

    def lines(self, world: LiveWorld) -> list[Line]:
        """Return the new lines of both directions."""
        reader, since_s = self.part(world), world.device.powered_s
        found = [*self._typed, *(Line(since_s + at_s, True, text) for at_s, text in reader.lines)]
        self._typed.clear()
        reader.lines.clear()
        return found

    def act(self, live: Live, order: Order) -> None:
        """Send a command."""
        line = text_of(order, "line", 80)
        self.part(live.world).send_bytes(f"{line}\r\n".encode())
        self._typed.append(Line(live.world.now_s, False, line))
        live.remark(f"{line} was typed at the log")


take = LogTerminal
