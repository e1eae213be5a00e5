"""The cases of tests/bad_specs: a base, what is changed in it, and the messages; read once.

A file is of one subject. A case in it is a head, and lines that begin with a sign:

    [window_too_short of pid_oven] Fewer steps than per cents.
    = window: 1 s -> window: 500 ms
    > 6:60: outputs.heater.window: 500 ms is shorter than …

`=` is text that stands once in the base, and what stands in its place; where one of them has
several lines, `-` are those of the base, and `+` are the others. `-` alone takes out whole lines,
`+` alone is put at the end. `^` puts a line above the one that has this text; without an arrow,
the `+` that follow. An empty line ends a change. `~` is a `+` in which Python's escapes count,
and `\\udcb0` is the byte B0. `* 3` is a `+` that is there three times: {n} in it counts from 0.
`>` is a message, without the file's name. `|` begins another case of the same base, which is
called window_too_short_2: it is a `=`, or says what the case is.

The base is a good spec of bases.txt, or another case; a case without one is written out whole.
A line that begins with # says something about the file.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from types import MappingProxyType

from heatwright.spec import SpecError, load_text

FOLDER = Path(__file__).parents[1] / "bad_specs"
BASES = FOLDER / "bases.txt"
FILE_NAME = "spec.yaml"
HEAD = re.compile(r"\[(\w+)(?: of (\w+))?\](?: .+)?")


@dataclass(frozen=True)
class Case:
    text: bytes
    messages: tuple[str, ...]

    @property
    def expected(self) -> str:
        """The error's words: a line for each message, with the name of the file."""
        return "\n".join(f"{FILE_NAME}:{message}" for message in self.messages)

    def refusal(self) -> SpecError:
        """Load the spec and return the error.

        Raises AssertionError: it is taken for a good one.
        """
        try:
            load_text(self.text, FILE_NAME)
        except SpecError as error:
            return error
        raise AssertionError("the spec is taken for a good one")


@cache
def cases() -> Mapping[str, Case]:
    entries = _entries(FOLDER.glob("*.txt"))
    found = {
        name: Case(_text(entries, name).encode("utf-8", "surrogateescape"), tuple(entry.messages))
        for name, entry in entries.items()
        if entry.file != BASES
    }
    return MappingProxyType(found)


@cache
def bases() -> Mapping[str, str]:
    """Return the texts of the good specs that the bad ones are made of, by name."""
    entries = _entries([BASES])
    return MappingProxyType({name: _text(entries, name) for name in entries})


@dataclass
class _Change:
    old: list[str] = field(default_factory=list)
    new: list[str] = field(default_factory=list)
    above: str = ""


@dataclass
class _Entry:
    file: Path
    base: str | None
    changes: list[_Change] = field(default_factory=lambda: [_Change()])
    messages: list[str] = field(default_factory=list)

    def read(self, line: str) -> None:
        sign, text = line[:1], line[2:]
        if sign == ">":
            self.messages.append(text)
        elif sign == "=":
            old, _, new = text.partition(" -> ")
            self.changes += [_Change([old], [new]), _Change()]
        elif sign == "^":
            above, arrow, new = text.partition(" -> ")
            self.changes.append(_Change([], [new] if arrow else [], above))
            self.changes += [_Change()] if arrow else []
        elif sign == "-" and not self.changes[-1].new:
            self.changes[-1].old.append(text)
        elif sign in {"", "-"}:
            self.changes.append(_Change([text] if sign else []))
        else:
            self.changes[-1].new += _added(sign, text)


def _added(sign: str, text: str) -> list[str]:
    if sign == "+":
        return [text]
    if sign == "~":
        return [text.encode("ascii").decode("unicode_escape")]
    assert sign == "*", f"{sign} is no sign"
    count, _, pattern = text.partition(" ")
    return [pattern.replace("{n}", str(number)) for number in range(int(count))]


def _entries(files: Iterable[Path]) -> dict[str, _Entry]:
    found: dict[str, _Entry] = {}
    for file in sorted(files):
        first, count, entry = "", 0, _Entry(file, None)
        for line in file.read_text("utf-8").split("\n"):
            head = HEAD.fullmatch(line)
            if head or line.startswith("|"):
                first, count = (head[1], 1) if head else (first, count + 1)
                name = first if count == 1 else f"{first}_{count}"
                assert name not in found, f"{file.name}: there are two cases {name}"
                entry = found[name] = _Entry(file, head[2] if head else entry.base)
                if " -> " in line and not head:
                    entry.read(f"={line[1:]}")
            elif not line.startswith("#"):
                entry.read(line)
    return found


def _text(entries: Mapping[str, _Entry], name: str) -> str:
    entry = entries[name]
    text = _text(entries, entry.base) if entry.base else ""
    for change in entry.changes:
        text = _changed(name, text, change)
    return text


def _changed(name: str, text: str, change: _Change) -> str:
    old, new = "\n".join(change.old) or change.above, "\n".join(change.new)
    if not old:
        return text + "".join(f"{line}\n" for line in change.new)
    if not change.new:  # whole lines
        text, old = f"\n{text}", f"\n{old}\n"
    assert text.count(old) == 1, f"{name}: in its base it stands {text.count(old)} times: {old}"
    if change.above:
        before = text.rfind("\n", 0, text.index(old)) + 1
        return f"{text[:before]}{new}\n{text[before:]}"
    return text.replace(old, new) if change.new else text.replace(old, "\n")[1:]
