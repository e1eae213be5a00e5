"""Printrun's printcore, as it is, and what it has heard."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from printrun.gcoder import LightGCode
from printrun.printcore import printcore

PATIENCE_S = 120.0
"""Real time after which something is not going to happen."""
GLANCE_S = 0.01


class PrintrunHost:
    """heard -- all lines; temperatures -- those that printcore took for temperatures; errors."""

    def __init__(self, core: Any) -> None:
        self.core = core
        self.heard: list[str] = []
        self.temperatures: list[str] = []
        self.errors: list[str] = []
        core.recvcb = lambda line: self.heard.append(line.rstrip())
        core.tempcb = lambda line: self.temperatures.append(line.rstrip())
        core.errorcb = lambda line: self.errors.append(str(line).rstrip())

    def print(self, lines: list[str]) -> None:
        """Send lines as a print is sent, numbered and with checksums; wait for the end."""
        assert self.core.startprint(LightGCode(lines))
        self.wait(lambda: not self.core.printing)
        self.wait(self._listens_again)

    def _listens_again(self) -> bool:
        """Whether printcore has left its printing for its sending thread: it ends badly between."""
        core = self.core
        return (
            core.print_thread is None
            and core.send_thread is not None
            and core.send_thread.is_alive()
        )

    def ask(self, line: str, answer: str) -> str:
        """Send a line beside any print; wait for an answer that begins so."""
        known = len(self.heard)
        self.core.send_now(line)
        self.wait(lambda: any(text.startswith(answer) for text in self.heard[known:]))
        return next(text for text in self.heard[known:] if text.startswith(answer))

    def wait(self, done: Callable[[], bool]) -> None:
        """Wait until something has happened."""
        end = time.monotonic() + PATIENCE_S
        while not done():
            assert time.monotonic() < end, self.heard[-10:]
            time.sleep(GLANCE_S)


@contextmanager
def printrun_host(port: str, baud: int) -> Iterator[PrintrunHost]:
    """Connect printcore to a port."""
    core = printcore()
    host = PrintrunHost(core)
    core.connect(port, baud)
    try:
        host.wait(lambda: core.online)
        yield host
    finally:
        core.disconnect()
