"""Progress on standard error: bars on a terminal, a plain line for each job elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Protocol

import click

Progress = Callable[[float, float], None]
"""Called with the work done so far, and all the work."""


class Job(Protocol):
    """One line of the progress."""

    def __call__(self, done: float, total: float) -> None:
        """Show the progress."""

    def note(self, text: str) -> None:
        """Show what the job is doing now."""

    def end(self, text: str = "") -> None:
        """Show that the job is done, and its result."""


class Talk(Protocol):
    """Where jobs are shown: `with talk() as t: job = t.begin("Building")`."""

    def begin(self, what: str, *, waits: bool = False) -> Job:
        """Show a job; with `waits` its clock starts with its first progress or note."""

    def __enter__(self) -> Talk:
        """Start showing."""

    def __exit__(self, *_: object) -> None:
        """Leave the terminal as it was."""


def talk() -> Talk:
    """Return the progress that fits standard error."""
    if sys.stderr is not None and sys.stderr.isatty():
        from heatwright.cli.bars import Bars  # noqa: PLC0415 - rich takes a while to import

        return Bars()
    return _Plain()


class _Plain:
    """A line when a job begins and one when it ends with a result."""

    def begin(self, what: str, *, waits: bool = False) -> Job:
        del waits
        click.echo(f"{what} …", err=True)
        return _PlainJob(what)

    def __enter__(self) -> Talk:
        return self

    def __exit__(self, *_: object) -> None:
        pass


class _PlainJob:
    def __init__(self, what: str) -> None:
        self._what = what

    def __call__(self, done: float, total: float) -> None:
        pass

    def note(self, text: str) -> None:
        pass

    def end(self, text: str = "") -> None:
        if text:
            click.echo(f"{self._what}: {text}", err=True)


class Counter:
    """Shows as one job how many pieces of work are done."""

    def __init__(self, job: Job, total: int) -> None:
        self._job = job
        self._total = total
        self._done = 0

    def __call__(self, done: float, total: float) -> None:
        """Ignore the progress of a single piece of work."""

    def note(self, text: str) -> None:
        """Ignore the notes of a single piece of work."""

    def end(self, text: str = "") -> None:
        """Show that one more piece of work is done."""
        del text
        self._done += 1
        self._job(self._done, self._total)
