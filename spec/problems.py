"""Errors of a spec: where, why, and what to do; and the marks of fields that find them."""

from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

from pydantic_core import PydanticCustomError, core_schema

Path: TypeAlias = tuple[str | int, ...]
"""Keys and list indices from the root of the file, such as ("loops", "air", "period")."""


LONGEST_QUOTE = 40
"""Maximum number of characters of the file that are quoted in a message."""


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
    """One error at one place of a file."""

    file: str
    line: int
    column: int
    path: str
    reason: str
    remedy: str

    def __str__(self) -> str:
        where = f"{self.file}:{self.line}:{self.column}: "
        what = f"{self.path}: " if self.path else ""
        stop = "" if self.remedy.endswith("?") else "."
        return f"{where}{what}{self.reason}. {self.remedy}{stop}"


class SpecError(Exception):
    """All problems of a spec, in the order of their positions."""

    def __init__(self, problems: tuple[Problem, ...]) -> None:
        super().__init__(problems)
        self.problems = problems

    def __str__(self) -> str:
        return "\n".join(map(str, self.problems))


class Checked:
    """Marks a model's field that a function of heatwright reads: `Annotated[str, Checked(…)]`."""

    def __init__(self, read: Callable[[Any], object], **json_schema: object) -> None:
        """Read values with `read`; `json_schema` describes what it accepts to editors."""
        self.read = read
        self.json_schema = json_schema

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)


def refuse(reason: str, remedy: str) -> PydanticCustomError:
    """Make the error a model's validator raises; the loader gives it file, line and column."""
    return PydanticCustomError("spec", "{reason}", {"reason": reason, "remedy": remedy})
