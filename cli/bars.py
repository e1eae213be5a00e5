"""Progress on a terminal."""

from __future__ import annotations

from types import TracebackType

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, SpinnerColumn, TaskID, TextColumn, TimeElapsedColumn

from heatwright.cli.talk import Job, Talk

NOTE = 48
"""Characters of a note; more would push the bar off a narrow terminal."""


class Bars:
    """One bar for each job that has begun; they vanish at the end, the results stay."""

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

    def begin(self, what: str) -> Job:
        """Add a bar."""
        return _Bar(self._progress, self._progress.add_task(escape(what), total=None, note=""))

    def __enter__(self) -> Talk:
        """Start showing."""
        self._progress.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Take the bars away."""
        self._progress.stop()


class _Bar:
    def __init__(self, progress: Progress, task: TaskID) -> None:
        self._progress = progress
        self._task = task

    def __call__(self, done: float, total: float) -> None:
        self._progress.update(self._task, completed=done, total=total)

    def note(self, text: str) -> None:
        self._progress.update(self._task, note=escape(text[:NOTE]))

    def end(self, text: str = "") -> None:
        self._progress.update(self._task, completed=1, total=1, note=escape(text[:NOTE]))
