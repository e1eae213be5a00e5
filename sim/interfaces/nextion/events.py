"""The code of a Nextion page's events: instructions, and blocks after if and else."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import lru_cache

REMEMBERED = 4096
"""Parsed events to cache: a display is powered on for each fault, with the same pages."""


class PageError(ValueError):
    """Code of a page that the editor would refuse; the message says where."""


@dataclass(frozen=True)
class Choice:
    """A condition, and the code for true and for false."""

    condition: str
    then: tuple[str | Choice, ...]
    otherwise: tuple[str | Choice, ...]


Code = tuple[str | Choice, ...]


@lru_cache(maxsize=REMEMBERED)
def read(lines: tuple[str, ...]) -> Code:
    """Parse the lines of an event. Raises PageError."""
    words = _Words(lines)
    code = words.code()
    if words.left:
        raise PageError(f"There is one }} too many before {words.left[0]!r}.")
    return code


class _Words:
    """The code split into braces, if and else, conditions, and instructions."""

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
            raise PageError(f"After if comes no (condition), but {condition!r}.")
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
            raise PageError("A { is missing after a condition or after else.")
        inside = self.code()
        if not self.left:
            raise PageError("A { is never closed.")
        self.left.pop(0)
        return inside


def _pieces(line: str) -> list[str]:
    """Split a line; an instruction takes all the rest of it, with braces inside its texts."""
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
    """Return a text up to the parenthesis that closes its first one."""
    depth = 0
    for place, character in enumerate(text):
        depth += (character == "(") - (character == ")")
        if depth == 0:
            return text[: place + 1]
    return text


def run(code: Code, do: Callable[[str], bool], holds: Callable[[str], bool]) -> bool:
    """Run an event's code.

    do -- executes an instruction, and returns whether the page has changed: the rest is then not
    run; holds -- evaluates a condition. Returns whether the page has changed.
    """
    for each in code:
        if isinstance(each, Choice):
            gone = run(each.then if holds(each.condition) else each.otherwise, do, holds)
        else:
            gone = do(each)
        if gone:
            return True
    return False
