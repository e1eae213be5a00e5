"""What the mutation engine asks of an area of the tests: C to break, and a judge of it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Protocol


class Arena(Protocol):
    """One firmware (or part of one) whose C is broken, and what then has to complain."""

    name: str
    """`area/specification`, as it stands in reports and on the command line."""
    together: bool
    """Whether all mutants are compiled into one library, and chosen by its variable `mutant`
    (host builds that are loaded into this process); else each is compiled by itself."""

    def sources(self) -> Mapping[str, str]:
        """Return the files that may be broken: name in `src/`, and text."""

    def build(self, changed: Mapping[str, str], folder: Path) -> Path:
        """Compile with these texts in place of the files' own, without warnings.

        Raises:
            Exception: it does not compile; such a mutant does not count.

        """

    def prepare(self) -> None:
        """Compute what all trials share (expected courses): called once, before any `problem`."""

    def problem(self, built: Path) -> str:
        """Judge what was built: say the first thing that is wrong; empty if nothing is.

        It runs in a process of its own, which may end, hang or raise: then the mutant is killed.
        What is quick to kill with comes first.
        """
