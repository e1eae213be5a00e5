"""Readings of a loop from the entries of its log, which is requested again and again."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from heatwright.cli.plot.hearing import Hearing, Reading, known
from heatwright.sim.identify.cells import DIALECTS, fields, value
from heatwright.spec import Controller, SerialLog

LEAST_S = 10.0
"""Shortest time between two requests: an answer of 600 entries takes 6 s."""
WIDTH = 4
_COMMAS = DIALECTS[0]


def hearings(controller: Controller, interface: SerialLog) -> Iterator[Hearing]:
    """Yield the way to read the log's loop."""
    del controller
    every_s = max(LEAST_S, interface.every_s)
    yield Hearing(interface.loop, interface.kind, interface.line, _Logged(), b"log\n", every_s)


@dataclass
class _Logged:
    """Reads the answers to `log`: each has all entries, and only new ones are yielded.

    The log's clock restarts with the board: the times of later entries then continue from the
    newest entry before the restart.
    """

    newest_s: float = -1.0
    before_s: float = 0.0
    answer: list[Reading] = field(default_factory=list)

    def __call__(self, line: str, time_s: float) -> Iterator[Reading]:
        del time_s
        if line.startswith("time_s,"):
            self.answer.clear()
        elif not line:
            yield from self._new()
        else:
            cells = [value(text, _COMMAS) for text in fields(line, _COMMAS)]
            at_s, *told = (known(each) for each in cells[:WIDTH])
            if len(cells) >= WIDTH and at_s is not None:
                self.answer.append(Reading(at_s, *told))

    def _new(self) -> Iterator[Reading]:
        if not self.answer:
            return
        if self.answer[-1].time_s < self.newest_s:
            self.before_s += self.newest_s
            self.newest_s = -1.0
        for each in self.answer:
            if each.time_s > self.newest_s:
                self.newest_s = each.time_s
                yield each._replace(time_s=self.before_s + each.time_s)
        self.answer.clear()
