"""Progress on a terminal."""

import os

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, SpinnerColumn, TaskID, TextColumn, TimeElapsedColumn

from heatwright.cli.talk import Job, Talk

NOTE = 48
"""Maximum number of characters of a note; more would push the bar off a narrow terminal."""


class Bars:
    """One progress bar for each job; the bars vanish at the end."""

    def __init__(self) -> None:
        self._progress = Progress(
            SpinnerColumn(finished_text="[green]✓"),
            TextColumn("{task.description}"),
            BarColumn(bar_width=24),
            TimeElapsedColumn(),
            TextColumn("[dim]{task.fields[note]}"),
            console=Console(stderr=True),
            transient=True,
        )
        self._shows = False

    def begin(self, what: str, *, waits: bool = False) -> Job:
        """Add a bar."""
        task = self._progress.add_task(escape(what), start=not waits, total=None, note="")
        return _Bar(self._progress, task, started=not waits)

    def __enter__(self) -> Talk:
        """Start showing; nothing is drawn while a process is forked.

        A lock that the drawing thread holds at that moment would stay locked in the new process.
        """
        os.register_at_fork(before=self._pause, after_in_parent=self._go_on)
        self._shows = True
        self._go_on()
        return self

    def _pause(self) -> None:
        if self._shows:
            self._progress.stop()

    def _go_on(self) -> None:
        if self._shows:
            self._progress.start()

    def __exit__(self, *_: object) -> None:
        """Remove the bars from the screen."""
        self._pause()
        self._shows = False


class _Bar:
    def __init__(self, progress: Progress, task: TaskID, *, started: bool) -> None:
        self._progress = progress
        self._task = task
        self._started = started

    def _start(self) -> None:
        if not self._started:
            self._started = True
            self._progress.start_task(self._task)

    def __call__(self, done: float, total: float) -> None:
        self._start()
        self._progress.update(self._task, completed=done, total=total)

    def note(self, text: str) -> None:
        self._start()
        self._progress.update(self._task, note=escape(text[:NOTE]))

    def end(self, text: str = "") -> None:
        self._start()
        self._progress.update(self._task, completed=1, total=1, note=escape(text[:NOTE]))
