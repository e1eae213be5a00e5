"""A terminal on the line of a G-code host: typed lines are sent without line numbers."""

from collections import deque
from typing import Any

from heatwright.cli.bench.parts.seat import Line, Live, Order, Seat, text_of
from heatwright.cli.bench.recorded import event_of
from heatwright.cli.bench.world import LiveWorld
from heatwright.spec import Controller

MOST_TYPED = 1000
"""Maximum number of lines that may wait for the board."""


class Terminal(Seat):
    """A person who types G-code."""

    kind = "gcode"

    def __init__(self, controller: Controller, number: int) -> None:
        super().__init__(controller, number)
        self._typed: deque[str] = deque(maxlen=MOST_TYPED)
        self._polling = False

    def about(self) -> dict[str, Any]:
        """Return the features of the terminal, and the lines that it suggests."""
        return {"types": True, "polls": True, "hints": ["M105", "M115", "M503", "M112", "M999"]}

    def lines(self, world: LiveWorld) -> list[Line]:
        """Return the new lines of both directions."""
        host, since_s = self.part(world), world.device.powered_s
        host.numbers = False
        found = [Line(since_s + each.time_s, True, each.text) for each in host.lines]
        found += [Line(since_s + each.time_s, False, each.text) for each in host.sent]
        host.lines.clear()
        host.sent.clear()
        return [self._marked(line) for line in sorted(found, key=lambda line: line.time_s)]

    def _marked(self, line: Line) -> Line:
        """Mark the host's own requests, and the answer to each up to its `ok`."""
        if not line.sent:
            self._polling = not (self._typed and self._typed[0] == line.text)
            if not self._polling:
                self._typed.popleft()
            return line._replace(by_itself=self._polling)
        marked = line._replace(by_itself=self._polling)
        if line.text.startswith("ok"):
            self._polling = False
        return marked

    def act(self, live: Live, order: Order) -> None:
        """Send a line."""
        line = text_of(order, "line")
        self.part(live.world).numbers = False
        what = {"send": line}
        event_of(what)
        self._typed.append(line)
        live.world.device.send(line)
        live.record(what)


take = Terminal
