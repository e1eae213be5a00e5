"""The code of a Nextion page's events: instructions, and blocks behind if and else."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import lru_cache

REMEMBERED = 4096
"""Events: those of all pages of a display, which is powered on for each fault."""


class PageError(ValueError):
    """A page's code that the editor would refuse; says where."""


@dataclass(frozen=True)
class Choice:
    """A condition, and what is done if it holds or does not."""

    condition: str
    then: tuple[str | Choice, ...]
    otherwise: tuple[str | Choice, ...]


Code = tuple[str | Choice, ...]


@lru_cache(maxsize=REMEMBERED)
def read(lines: tuple[str, ...]) -> Code:
    """Read the lines of an event. Raises PageError."""
    words = _Words(lines)
    code = words.code()
    if words.left:
        raise PageError(f"There is a }} too many before {words.left[0]!r}.")
    return code


class _Words:
    """The code cut into braces, if and else, conditions, and instructions."""

    def __init__(self, lines: Iterable[str]) -> None:
        self.left = [piece for line in lines for piece in _pieces(line)]

    def code(self) -> Code:
        found: list[str | Choice] = []
        while self.left and self.left[0] != "}":
            word = self.left.pop(0)
            if word == "if":
                found.append(self._choice())
            elif word in ("{", "else"):
                raise PageError(f"There is no if before {word!r}.")
            else:
                found.append(word)
        return tuple(found)

    def _choice(self) -> Choice:
        condition = self.left.pop(0) if self.left else ""
        if not condition.startswith("(") or not condition.endswith(")"):
            raise PageError(f"Behind if stands no (condition), but {condition!r}.")
        then = self._block()
        otherwise: Code = ()
        if self.left and self.left[0] == "else":
            self.left.pop(0)
            if self.left and self.left[0] == "if":
                self.left.pop(0)
                otherwise = (self._choice(),)
            else:
                otherwise = self._block()
        return Choice(condition[1:-1], then, otherwise)

    def _block(self) -> Code:
        if not self.left or self.left.pop(0) != "{":
            raise PageError("Behind a condition and behind else stands a {.")
        inside = self.code()
        if not self.left:
            raise PageError("A { is never closed.")
        self.left.pop(0)
        return inside


def _pieces(line: str) -> list[str]:
    """Cut a line; an instruction takes all that is left of it, and its own braces in texts."""
    text = line.strip()
    pieces: list[str] = []
    while text:
        if text[0] in "{}":
            piece = text[0]
        elif found := re.match(r"(if)\s*(?=\()|(else)(?!\w)", text):
            piece = found[1] or found[2]
        elif pieces and pieces[-1] == "if":
            piece = _condition(text)
        else:
            piece = text
        pieces.append(piece)
        text = text[len(piece) :].strip()
    return pieces


def _condition(text: str) -> str:
    """Return a text up to the parenthesis that closes its first."""
    depth = 0
    for place, character in enumerate(text):
        depth += (character == "(") - (character == ")")
        if depth == 0:
            return text[: place + 1]
    return text


def run(code: Code, do: Callable[[str], bool], holds: Callable[[str], bool]) -> bool:
    """Run an event's code.

    do -- does an instruction, and says whether the page has gone: the rest is then never run;
    holds -- judges a condition. Returns whether the page has gone.
    """
    for each in code:
        if isinstance(each, Choice):
            gone = run(each.then if holds(each.condition) else each.otherwise, do, holds)
        else:
            gone = do(each)
        if gone:
            return True
    return False
