"""Parse a line of G-code."""

import re
from typing import NamedTuple

_WORD = re.compile(r"([A-Z])(-?\d+\.?\d*|-?\.\d+)?")


class Line(NamedTuple):
    """A command and its words."""

    command: str
    """The command, such as `M104` or `T1`."""
    words: dict[str, float | None]
    """Number by letter; None: a letter without a number."""

    def number(self, letter: str) -> float | None:
        """Return the number after a letter; None if it is not there."""
        return self.words.get(letter)


def parsed(text: str) -> Line:
    """Parse a line; line number and checksum are ignored.

    Raises ValueError: it has no command.
    """
    plain = text.split(";", maxsplit=1)[0].split("*", maxsplit=1)[0].upper()
    words = [(letter, number) for letter, number in _WORD.findall(plain) if letter != "N"]
    if not words or words[0][0] not in "GMT" or not words[0][1]:
        raise ValueError(f"{text!r} has no command")
    (letter, code), *rest = words
    return Line(f"{letter}{int(float(code))}", {word: _value(number) for word, number in rest})


def _value(number: str) -> float | None:
    return float(number) if number else None
