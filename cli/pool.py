"""Work spread over processes, one for each core, with its progress and an end that is an end."""

from __future__ import annotations

import gc
import multiprocessing
import os
import queue
import signal
from collections import deque
from collections.abc import Callable, Container, Sequence
from types import FrameType
from typing import Any, TypeVar

from heatwright.cli.talk import Job

T = TypeVar("T")
R = TypeVar("R")

ENDS = {signal.SIGINT, signal.SIGTERM}
LOOK_S = 0.05
"""How often the results are polled while nothing is reported."""

_told: Any = None
"""In a worker: the queue to the process that shows the progress."""


class _Relay:
    """A job whose progress goes to the process that started the work."""

    def __init__(self, number: int) -> None:
        self._number = number

    def __call__(self, done: float, total: float) -> None:
        _told.put((self._number, "progress", (done, total)))

    def note(self, text: str) -> None:
        _told.put((self._number, "note", (text,)))

    def end(self, text: str = "") -> None:
        del text  # a piece of work has several such ends


class WorkerDied(RuntimeError):
    """A process has crashed, or the system has ended it: there is nothing to wait for."""


def processes() -> int:
    """Return how many run at a time: as many as there are cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _nothing(_: object) -> None:
    """Wait for the other results."""


def spread(
    work: Callable[[T, Job], R],
    pieces: Sequence[T],
    jobs: Sequence[Job],
    *,
    came: Callable[[R], None] = _nothing,
    most: int | None = None,
) -> list[R]:
    """Do each piece of work, several at a time; results in the order of the pieces.

    `work` is a function of a module, for it is called in other processes. Its first error ends
    everything and is raised here. `came` is given each result as soon as it is there; `most`:
    processes, in the place of as many as there are cores. They are forked: to import all anew takes
    one of them longer than most pieces of work.
    """
    context = multiprocessing.get_context("fork")
    told = context.Queue()
    count = min(most or processes(), len(pieces))
    # Ctrl-C is this process's business, which then ends the others: they inherit the deafness.
    # What tells a worker to end waits until it has left this process's answer to that: else it is
    # lost, and whoever waits for that worker waits for ever.
    signal.pthread_sigmask(signal.SIG_BLOCK, ENDS)
    try:
        pool = context.Pool(count, initializer=_begin, initargs=(told,))
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDS)
    workers = multiprocessing.active_children()
    over: deque[int] = deque()

    def begun(number: int) -> Any:
        def ended(_: object) -> None:
            over.append(number)

        work_of = (work, pieces[number], number)
        return pool.apply_async(_do, work_of, callback=ended, error_callback=ended)

    with pool:
        results = [begun(number) for number in range(len(pieces))]
        waiting = set(range(len(pieces)))
        while waiting:
            _show(told, jobs, waiting)
            if not all(worker.is_alive() for worker in workers):
                raise WorkerDied("a worker process ended by itself")
            while over:
                number = over.popleft()
                waiting.remove(number)
                came(results[number].get())
                jobs[number].end()
        return [result.get() for result in results]


def _show(told: Any, jobs: Sequence[Job], waiting: Container[int]) -> None:
    try:
        number, what, values = told.get(timeout=LOOK_S)
    except queue.Empty:
        return
    if number in waiting:
        job = jobs[number]
        (job if what == "progress" else job.note)(*values)


def _do(work: Callable[[T, Job], R], piece: T, number: int) -> R:
    heard = signal.signal(signal.SIGTERM, _clean_up)
    try:
        return work(piece, _Relay(number))
    finally:
        signal.signal(signal.SIGTERM, heard)


def _begin(told: Any) -> None:
    """Set up a worker; what the command does when it is told to end is no business of it.

    What it has from the process that forked it lives as long as it does, and to look through all
    that for garbage took a fifteenth of the time.
    """
    gc.freeze()
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})
    global _told  # noqa: PLW0603 - the one thing a worker has of its own
    _told = told


def _clean_up(_: int, __: FrameType | None) -> None:
    """End in order: temporary folders vanish, and the compiler stops.

    Where the signal comes in a function that C has called, the exit is lost there: try it again.
    """
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # what C has called would tell of the exit
    signal.signal(signal.SIGALRM, _clean_up)
    signal.alarm(1)
    raise SystemExit
