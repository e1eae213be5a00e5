"""Work spread over two processes, with the progress of each piece, and an end that is an end."""

from __future__ import annotations

import multiprocessing
import queue
import signal
from collections.abc import Callable, Container, Sequence
from types import FrameType
from typing import Any, TypeVar

from heatwright.cli.talk import Job

T = TypeVar("T")
R = TypeVar("R")

PROCESSES = 2
LOOK_S = 0.05
"""How often the results are looked for while nothing is told."""

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


def spread(work: Callable[[T, Job], R], pieces: Sequence[T], jobs: Sequence[Job]) -> list[R]:
    """Do each piece of work, two at a time; results in the order of the pieces.

    `work` is a function of a module, for it is called in other processes. Its first error ends
    everything and is raised here. The processes are forked: to import all anew takes one of them
    longer than most pieces of work.
    """
    context = multiprocessing.get_context("fork")
    told = context.Queue()
    processes = min(PROCESSES, len(pieces))
    # Ctrl-C is this process's business, which then ends the others: they inherit the deafness.
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        pool = context.Pool(processes, initializer=_begin, initargs=(told,))
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    workers = multiprocessing.active_children()
    with pool:
        results = [
            pool.apply_async(_do, (work, piece, number)) for number, piece in enumerate(pieces)
        ]
        waiting = dict(enumerate(results))
        while waiting:
            _show(told, jobs, waiting)
            if not all(worker.is_alive() for worker in workers):
                raise WorkerDied("a worker process ended by itself")
            for number in [number for number, result in waiting.items() if result.ready()]:
                waiting.pop(number).get()
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
    """Set up a worker; what the command does when it is told to end is no business of it."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    global _told  # noqa: PLW0603 - the one thing a worker has of its own
    _told = told


def _clean_up(_: int, __: FrameType | None) -> None:
    """End in order: temporary folders vanish, and the compiler stops.

    Where the signal comes in a function that C has called, the exit is lost there: try it again.
    """
    signal.signal(signal.SIGALRM, _clean_up)
    signal.alarm(1)
    raise SystemExit
