"""Reads YAML to plain data and the position of every key, in one pass over the parser's events."""

import re
from typing import Any, TypeAlias

import yaml

from heatwright.spec.loading.text import Unreadable
from heatwright.spec.problems import LONGEST_QUOTE, Path, Problem, dotted, shown
from heatwright.spec.quantity import NUMBER

DEEPEST = 24
"""Maximum number of levels of nesting; the language needs eight."""

# YAML 1.1 would read `off` as false, `1:30` as 90 and 010 as 8: only these words and decimal
# numbers mean anything here, everything else is text.
_WORDS = {"true": True, "false": False, "null": None, "~": None, "": None}
_INTEGER = re.compile(r"[+-]?\d{1,18}", re.ASCII)
_FLOAT = re.compile(NUMBER, re.ASCII)

Data: TypeAlias = "dict[str, Any] | tuple[Any, ...] | str | int | float | bool | None"
Position: TypeAlias = tuple[int, int]

_Loader: Any = getattr(yaml, "CBaseLoader", yaml.BaseLoader)


class Tree:
    """A parsed file. Sequences are tuples, because no other code changes them."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.data: Data = None
        # Line and column, from 1, of the key of each entry and of the start of each item.
        self.positions: dict[Path, Position] = {}
        # The first error in the form of each entry, such as a repeated key, no value or a tag.
        self.problems: dict[Path, Problem] = {}

    def position(self, path: Path) -> Position:
        """Find an entry, or the nearest one that contains it, in the file."""
        while path and path not in self.positions:
            path = path[:-1]
        return self.positions.get(path, (1, 1))

    def problem(self, path: Path, reason: str, remedy: str) -> Problem:
        """Make a problem of the entry at `path`."""
        return Problem(self.file, *self.position(path), dotted(path), reason, remedy)


def parse(text: str, file: str) -> Tree:
    """Parse one document. Raises Unreadable: YAML's grammar is broken."""
    tree = Tree(file)
    try:
        _Parser(text, tree).document()
    except yaml.MarkedYAMLError as error:
        raise Unreadable(_grammar_problem(error, text, file)) from None
    except (yaml.YAMLError, UnicodeEncodeError) as error:  # PyYAML's C code encodes the text again
        reason = f"this is not YAML: {error}".splitlines()[0]
        raise Unreadable(Problem(file, 1, 1, "", reason, "Correct it")) from None
    return tree


def _grammar_problem(error: yaml.MarkedYAMLError, text: str, file: str) -> Problem:
    mark = error.problem_mark or error.context_mark
    line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
    what = " ".join(filter(None, (error.context, error.problem))) or "cannot be parsed"
    return Problem(
        file,
        min(line, text.count("\n") + 1),
        column,
        "",
        f"this is not YAML: {what}",
        "Check the indentation, colons, brackets and quotation marks here and on the line before",
    )


class _Parser:
    """Recursive descent over the events, no deeper than DEEPEST."""

    def __init__(self, text: str, tree: Tree) -> None:
        self._events = iter(yaml.parse(text, Loader=_Loader))
        self._tree = tree

    def document(self) -> None:
        """Read the only document into the tree."""
        tree = self._tree
        next(self._events)  # the start of the stream
        if isinstance(next(self._events), yaml.StreamEndEvent):
            tree.problems[()] = Problem(
                tree.file, 1, 1, "", "the file is empty", "Start it with heatwright: 1"
            )
            return
        tree.data = self._node(next(self._events), ())
        next(self._events)  # the end of the document
        event = next(self._events)
        if not isinstance(event, yaml.StreamEndEvent):
            raise self._stop(event, "a second document begins here", "Keep one spec in a file")

    def _node(self, event: yaml.Event, path: Path) -> Data:
        if len(path) > DEEPEST:
            raise self._stop(event, f"more than {DEEPEST} levels are nested", "Take levels out")
        if isinstance(event, yaml.AliasEvent):
            self._note(path, "an alias (*) is not part of the language", "Write the value here")
            return None
        if getattr(event, "anchor", None) is not None:
            self._note(path, "an anchor (&) is not part of the language", "Delete it")
        if getattr(event, "tag", None) is not None:
            self._note(path, "a tag (!) is not part of the language", "Delete it")
        if isinstance(event, yaml.MappingStartEvent):
            return self._mapping(path)
        if isinstance(event, yaml.SequenceStartEvent):
            return self._sequence(path)
        return self._scalar(event, path)

    def _mapping(self, path: Path) -> dict[str, Any]:
        found: dict[str, Any] = {}
        while not isinstance(event := next(self._events), yaml.MappingEndEvent):
            key = self._key(event, path)
            value_event = next(self._events)
            if key is None or key in found:
                self._skip(value_event, len(path))
                continue
            inner = (*path, key)
            self._tree.positions[inner] = _position(event)
            found[key] = self._node(value_event, inner)
        return found

    def _key(self, event: Any, path: Path) -> str | None:
        """Read a key; None if it cannot be used, which is reported as a problem."""
        if not isinstance(event, yaml.ScalarEvent):
            self._skip(event, len(path))
            self._note_key(event, path, "a key must be a word", "Write key: value")
            return None
        key: str = event.value
        if not key or len(key) > LONGEST_QUOTE or not key.isprintable():
            self._note_key(event, path, f"{shown(key)} is no key", "Write key: value")
            return None
        if key == "<<" and not event.style:
            self._note_key(event, path, "a merge key (<<) is not part of the language", "Delete it")
            return None
        first = self._tree.positions.get((*path, key))
        if first is not None:
            self._note_key(
                event, path, f"the key {key} is already on line {first[0]}", "Delete one of them"
            )
        return key

    def _sequence(self, path: Path) -> tuple[Any, ...]:
        found: list[Any] = []
        while not isinstance(event := next(self._events), yaml.SequenceEndEvent):
            inner = (*path, len(found))
            self._tree.positions[inner] = _position(event)
            found.append(self._node(event, inner))
        return tuple(found)

    def _scalar(self, event: Any, path: Path) -> Data:
        text: str = event.value
        if event.style not in (None, ""):
            return text
        if text in _WORDS:
            value = _WORDS[text]
            if value is None:
                self._note(path, "there is no value", "Give one, or delete the key")
            return value
        if _INTEGER.fullmatch(text):
            return int(text)
        return float(text) if _FLOAT.fullmatch(text) else text

    def _skip(self, event: yaml.Event, depth: int) -> None:
        """Skip a node that is not stored in the data."""
        opened = 0
        while True:
            if depth + opened > DEEPEST:
                raise self._stop(event, f"more than {DEEPEST} levels are nested", "Take levels out")
            opened += isinstance(event, yaml.CollectionStartEvent)
            opened -= isinstance(event, yaml.CollectionEndEvent)
            if opened == 0:
                return
            event = next(self._events)

    def _note(self, path: Path, reason: str, remedy: str) -> None:
        """Note a problem of the entry at `path`, unless it has one already."""
        self._tree.problems.setdefault(path, self._tree.problem(path, reason, remedy))

    def _note_key(self, event: yaml.Event, path: Path, reason: str, remedy: str) -> None:
        """Note a problem of a key in the mapping at `path`."""
        where = _position(event)
        problem = Problem(self._tree.file, *where, dotted(path), reason, remedy)
        self._tree.problems[(*path, f"{where[0]}:{where[1]}")] = problem

    def _stop(self, event: yaml.Event, reason: str, remedy: str) -> Unreadable:
        return Unreadable(Problem(self._tree.file, *_position(event), "", reason, remedy))


def _position(event: Any) -> Position:
    return event.start_mark.line + 1, event.start_mark.column + 1
