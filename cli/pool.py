"""Spreads work over processes, one for each core; shows progress, leaves no process behind."""

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
"""Time between two checks for results while no progress is reported, s."""

_told: Any = None
"""The queue of a worker to the process that shows the progress."""


class _Relay:
    """A job whose progress goes to the process that started the work."""

    def __init__(self, number: int) -> None:
        self._number = number

    def __call__(self, done: float, total: float) -> None:
        _told.put((self._number, "progress", (done, total)))

    def note(self, text: str) -> None:
        _told.put((self._number, "note", (text,)))

    def end(self, text: str = "") -> None:
        del text  # a job inside the piece of work has ended, not the piece itself


class WorkerDied(RuntimeError):
    """A worker process has crashed or was killed: its result will never come."""


def processes() -> int:
    """Return how many processes to start: one for each core that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _nothing(_: object) -> None:
    """Do nothing with a result that has come."""


def spread(
    work: Callable[[T, Job], R],
    pieces: Sequence[T],
    jobs: Sequence[Job],
    *,
    came: Callable[[R], None] = _nothing,
    most: int | None = None,
) -> list[R]:
    """Do each piece of work, several at a time; return the results in the order of the pieces.

    `work` must be a module's function, as other processes call it. Its first error ends all work
    and is raised here. `came` is called with each result at once; `most` limits the number of
    processes, which is otherwise the number of cores. Processes are forked: to import all modules
    again would take longer than most pieces of work.
    """
    context = multiprocessing.get_context("fork")
    told = context.Queue()
    count = min(most or processes(), len(pieces))
    # This process answers Ctrl-C and then ends the workers, which inherit the blocked signals.
    # SIGTERM is blocked until a worker has removed the handler that it inherits: that handler would
    # swallow the signal, and this process would wait for the worker without end.
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
                raise WorkerDied("a worker process has crashed or was killed")
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
    """Set up a worker, without the signal handlers of the command.

    Objects inherited by the fork live as long as the worker: searching them for garbage took a
    fifteenth of the time, so they are frozen.
    """
    gc.freeze()
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})
    global _told  # noqa: PLW0603 - each worker sets its own
    _told = told


def _clean_up(_: int, __: FrameType | None) -> None:
    """End the worker cleanly: temporary folders are deleted, and the compiler is stopped.

    SystemExit is lost in a callback from C code: so an alarm calls this handler again after 1 s.
    """
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # such C code would print the SystemExit
    signal.signal(signal.SIGALRM, _clean_up)
    signal.alarm(1)
    raise SystemExit
