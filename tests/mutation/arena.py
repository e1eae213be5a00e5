"""What the mutation engine asks of an area of the tests: C to break, and a judge of it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Protocol


class Arena(Protocol):
    """One firmware (or part of one) whose C is broken, and what then has to complain. Besides what
    stands here, the engine looks for two attributes that need not be there: `headers`, a function
    that returns the headers around the sources (name and text), for what they define and for the
    compiler's proof that a mutant is the same program; and `interrupted`, true where the judge sees
    a `volatile` or an atomic block that is missing."""

    name: str  # `area/specification`, as it stands in reports and on the command line
    together: bool
    """Whether all mutants are compiled into one library or program, for this computer: it takes
    the number of its mutant from the environment. Else each is compiled by itself."""

    def sources(self) -> Mapping[str, str]:
        """Return the files that may be broken: name in `src/`, and text. It compiles nothing
        that is not kept: also a run in which all is known calls it."""

    def build(self, changed: Mapping[str, str], folder: Path) -> Path:
        """Compile with these texts in place of the files' own, without warnings. Raises Exception:
        it does not compile; such a mutant does not count."""

    def prepare(self) -> None:
        """Compute what all trials share (expected courses): called once, before any `problem`."""

    def problem(self, built: Path) -> str:
        """Judge what was built: say the first thing that is wrong; empty if nothing is. It runs in
        a process of its own, which may end, hang or raise: then the mutant is killed. What is quick
        to kill with comes first."""
