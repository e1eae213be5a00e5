"""One mutant before its judge: in a process of its own that may crash, hang or raise."""

import contextlib
import os
import resource
import select
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from mutation.schema import VARIABLE

Judge = Callable[[Path], str]
PIPE_BYTES = 4000
WAITS = 20
"""Times its processor time may a mutant wait for something that never comes."""


@dataclass(frozen=True)
class Outcome:
    problem: str
    """What killed it; empty if nothing did."""
    seconds: float
    """Of the processor."""


class Trial:
    """A trial that runs."""

    def __init__(self, judge: Judge, built: Path, number: int, most_s: float) -> None:
        """Begin.

        Args:
            judge: says the first thing that is wrong with what was built.
            built: the program or library.
            number: which of its mutants; 0 for none.
            most_s: seconds of the processor after which it counts as hanging.

        """
        self._reads, writes = os.pipe()
        self._ends_at = time.monotonic() + WAITS * most_s
        self._most_s = most_s
        self.process = os.fork()
        if self.process == 0:
            os.setpgid(0, 0)
            os.close(self._reads)
            _judge(judge, built, number, most_s, writes)
        os.close(writes)

    def outcome(self) -> Outcome:
        """Wait for its end."""
        left_s = max(0.0, self._ends_at - time.monotonic())
        heard = bool(select.select([self._reads], [], [], left_s)[0])
        words = os.read(self._reads, PIPE_BYTES).decode(errors="replace") if heard else ""
        os.close(self._reads)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.process, signal.SIGKILL)
        _, _, used = os.wait4(self.process, 0)
        seconds = used.ru_utime + used.ru_stime
        if not words:
            words = "-it hangs" if not heard or seconds >= self._most_s else "-it crashes"
        return Outcome(words[1:], seconds)


def _judge(judge: Judge, built: Path, number: int, most_s: float, writes: int) -> None:
    """Never returns. The first character says that there is an answer."""
    try:
        os.environ[VARIABLE] = str(number)
        resource.setrlimit(resource.RLIMIT_CPU, (int(most_s) + 1, int(most_s) + 2))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        nowhere = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(nowhere, stream)
        try:
            words = "+" + judge(built)
        except BaseException as problem:
            words = f"-{type(problem).__name__}: {problem}"
        os.write(writes, words.encode()[:PIPE_BYTES])
    finally:
        os._exit(0)
