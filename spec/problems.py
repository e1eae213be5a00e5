"""What is wrong with a spec: where, why, and what to do about it."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

from pydantic_core import PydanticCustomError

Path: TypeAlias = tuple[str | int, ...]
"""Keys and list indices from the root of the file, such as ("loops", "air", "period")."""


LONGEST_QUOTE = 40
"""Characters of the file quoted in a message."""


def dotted(path: Path) -> str:
    """Write a key path as the messages do: `interfaces[0].baud`."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}"
    return text.removeprefix(".")


def shown(text: str) -> str:
    """Quote a piece of the file for a message, shortened if it is long."""
    return repr(text if len(text) <= LONGEST_QUOTE else text[: LONGEST_QUOTE - 1] + "…")


class Problem(NamedTuple):
    """One thing wrong in one place of one file."""

    file: str
    line: int
    column: int
    path: str
    reason: str
    remedy: str

    def __str__(self) -> str:
        where = f"{self.file}:{self.line}:{self.column}: "
        what = f"{self.path}: " if self.path else ""
        return f"{where}{what}{self.reason}. {self.remedy}."


class SpecError(Exception):
    """All problems of a spec, in the order of their positions."""

    def __init__(self, problems: tuple[Problem, ...]) -> None:
        super().__init__(problems)
        self.problems = problems

    def __str__(self) -> str:
        return "\n".join(map(str, self.problems))


def refuse(reason: str, remedy: str) -> PydanticCustomError:
    """Make the error a model's validator raises; the loader gives it file, line and column."""
    return PydanticCustomError("spec", "{reason}", {"reason": reason, "remedy": remedy})
