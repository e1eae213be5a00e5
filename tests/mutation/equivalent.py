"""`equivalent.txt`: mutants that nothing can tell from the original, and why."""

import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import NamedTuple

from mutation.syntax import Mutant

LIST = Path(__file__).with_name("equivalent.txt")


class Entry(NamedTuple):
    line: int
    pattern: str
    reason: str
    expression: re.Pattern[str]

    def fits(self, words: str) -> bool:
        """Whether it is about a mutant that the report prints so."""
        return self.expression.fullmatch(words) is not None


def entries(text: str) -> list[Entry]:
    """Read the list; a line that is not of the form that its head gives is an error."""
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        if not line or line.startswith("#"):
            continue
        pattern, _, reason = line.rpartition(" : ")
        if not pattern or not reason:
            message = f"equivalent.txt:{number}: no reason"
            raise ValueError(message)
        expression = re.compile(".*".join(map(re.escape, pattern.strip().split("…"))))
        found.append(Entry(number, pattern.strip(), reason.strip(), expression))
    return found


@cache
def listed() -> tuple[Entry, ...]:
    return tuple(entries(LIST.read_text(encoding="utf-8")))


def entry_of(mutants: Iterable[Mutant]) -> Entry | None:
    """Return the entry that one of these fits, which are the same one in several arenas."""
    return next((entry for words in {str(each) for each in mutants} if (entry := _of(words))), None)


@cache
def _of(words: str) -> Entry | None:
    return next((each for each in listed() if each.fits(words)), None)
