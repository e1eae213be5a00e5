"""What is certain of the generated C: so the engine leaves out mutants that can only be equal.

They are of three forms, and right for all C that is generated here:

- `>` and `!=`, or `==` and `<=`, between 0 and what has no sign. Without a sign are the unsigned
  types, bool and, in gcc, an enumeration without a negative value. A name counts if all of its
  declarations in the firmware, of variables, members, parameters and functions, are of such types;
- `i < N` and `i != N` as condition of `for (… i = 0; …; i++)`, also where `&&` joins it to others:
  nothing else in the loop changes `i` or takes its address, and N is a constant that is not below
  the first `i`, or a local name without a sign that nothing changes, so `i` meets N;
- a constant and another spelling of its value.

`equivalent.txt` says why nothing can tell other mutants from the original.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import tree_sitter_c
from tree_sitter import Language, Node, Parser

_HIDDEN = re.compile(rb"\bPROGMEM\b|__attribute__\s*\(\((?:[^()]|\([^()]*\))*\)\)|__extension__")
_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)
_DEFINED = re.compile(
    r"^[ \t]*#[ \t]*define[ \t]+([A-Z][A-Z0-9_]*)[ \t]+([-(]*(?:\d|[A-Z][A-Z0-9_]*\b(?!\()).*)$",
    re.MULTILINE,
)
_ENUM = re.compile(r"enum\s*\w*\s*\{(.*?)\}", re.DOTALL)
_ENTRY = re.compile(r"(?:^|,)\s*([A-Z][A-Z0-9_]*)\s*(?:=\s*([^,]+))?")
_UNSIGNED = re.compile(r"(uint\d+_t|bool|size_t|unsigned( \w+)*|enum\b.*)", re.DOTALL)
_DECLARING = ("declaration", "field_declaration", "parameter_declaration", "function_definition")
EQUAL_AT_0 = {(">", "!="), ("!=", ">"), ("==", "<="), ("<=", "==")}  # where x has no sign
LIST = Path(__file__).with_name("equivalent.txt")
MARKS = str.maketrans({"…": ".*", "‹": "(?:", "¦": "|", "›": ")"})
MIRRORED = {"<": ">", ">": "<", "<=": ">=", ">=": "<="}


class Names(NamedTuple):
    constants: Mapping[str, str] = MappingProxyType({})  # values are numbers if they are plain
    unsigned: frozenset[str] = frozenset()  # names of what has no sign, wherever it is declared
    macros: frozenset[str] = frozenset()
    """Those of the constants that another firmware may define with another value."""

    def is_zero(self, text: str) -> bool:
        return text not in self.macros and self.value(text) == "0"

    def value(self, text: str) -> str:
        """Return a constant's number as digits without a suffix, if it is plain; else a name."""
        seen = set()
        while text in self.constants and text not in seen:
            seen.add(text)
            text = self.constants[text].strip("()")
        if text == r"'\0'":
            return "0"
        return text.rstrip("uUlLfF") if text[:1].isdigit() else text


def names_of(sources: Mapping[str, str]) -> Names:
    text = "\n".join(_COMMENT.sub("", each) for each in sources.values())
    values = {name: value.strip() for name, value in _DEFINED.findall(text)}
    macros = frozenset(values)
    negative = False
    for body in _ENUM.findall(text):
        following = "0"
        for name, given in _ENTRY.findall(body):
            values[name] = given.strip() or following
            negative |= "-" in values[name]
            following = str(int(values[name]) + 1) if values[name].isdecimal() else ""
    signed, unsigned = set[str](), set[str]()
    for source in sources.values():
        for name, of in _declared(source):
            is_unsigned = _UNSIGNED.fullmatch(of) and not (negative and of.startswith("enum"))
            (unsigned if is_unsigned else signed).add(name)
    return Names(values, frozenset(unsigned - signed), macros)


@cache
def _declared(source: str) -> tuple[tuple[str, str], ...]:
    return tuple(
        (name, text_of(of))
        for node in everything(syntax_of(source.encode()))
        if node.type in _DECLARING and (of := node.child_by_field_name("type"))
        for declarator in node.children_by_field_name("declarator")
        if (name := name_of(declarator))
    )


@cache
def _parser() -> Parser:
    return Parser(Language(tree_sitter_c.language()))


def syntax_of(data: bytes) -> Node:
    """Parse a file; what is not of the language is blanked out, so that places stay the same."""
    return _parser().parse(_HIDDEN.sub(lambda found: b" " * len(found[0]), data)).root_node


def name_of(declarator: Node | None) -> str:
    """Return what a declarator gives a name: through pointers, arrays, parameters and a value."""
    while declarator is not None and declarator.type not in ("identifier", "field_identifier"):
        inner = declarator.child_by_field_name("declarator")
        declarator = inner or next(iter(declarator.named_children), None)
    return declarator.text.decode() if declarator is not None and declarator.text else ""


def everything(node: Node) -> Iterator[Node]:
    yield node
    for child in node.children:
        yield from everything(child)


def upwards(node: Node) -> Iterator[Node]:
    found: Node | None = node
    while found is not None:
        yield found
        found = found.parent


def ancestor(node: Node, kind: str) -> Node | None:
    return next((each for each in upwards(node) if each.type == kind), None)


def can_only_be_equal(node: Node, other: str, names: Names) -> bool:
    """Whether a comparison with this other operator says the same."""
    left, right = node.child_by_field_name("left"), node.child_by_field_name("right")
    operator = text_of(node.child_by_field_name("operator"))
    if left is None or right is None:
        return False
    if (operator, other) == ("<", "!=") and _counts_up(node, left, right, names):
        return True
    if names.is_zero(text_of(left)):
        left, right = right, left
        operator, other = MIRRORED.get(operator, operator), MIRRORED.get(other, other)
    equal = (operator, other) in EQUAL_AT_0 and names.is_zero(text_of(right))
    return equal and _has_no_sign(left, names)


def _has_no_sign(node: Node | None, names: Names) -> bool:
    if node is None:
        return False
    if node.type == "binary_expression":
        left = _has_no_sign(node.child_by_field_name("left"), names)
        right = _has_no_sign(node.child_by_field_name("right"), names)
        operator = text_of(node.child_by_field_name("operator"))
        return {"&": left or right, ">>": left}.get(operator, left and right and operator in "|/%")
    if node.type == "cast_expression":
        return bool(_UNSIGNED.fullmatch(text_of(node.child_by_field_name("type"))))
    if node.type == "parenthesized_expression":
        return len(node.named_children) == 1 and _has_no_sign(node.named_children[0], names)
    inner = {
        "subscript_expression": "argument", "update_expression": "argument",
        "pointer_expression": "argument", "field_expression": "field",
        "call_expression": "function",
    }.get(node.type)  # fmt: skip
    if inner:
        return _has_no_sign(node.child_by_field_name(inner), names)
    return names.value(text_of(node)).isdecimal() or text_of(node) in names.unsigned


def _counts_up(node: Node, left: Node, right: Node, names: Names) -> bool:
    """Whether it is a condition of a loop that counts up by 1 and meets its end."""
    around = node
    while around.parent is not None and (
        around.parent.type == "parenthesized_expression"
        or text_of(around.parent.child_by_field_name("operator")) == "&&"
    ):
        around = around.parent
    loop, counter = around.parent, text_of(left)
    if loop is None or loop.type != "for_statement":
        return False
    begins = text_of(loop.child_by_field_name("initializer"))
    start = re.fullmatch(rf"\w+ {counter} = (\w+);", begins)
    counts = text_of(loop.child_by_field_name("update")) == f"{counter}++"
    if not start or not counts or _changes(loop, counter) != 1:
        return False
    first, end = names.value(start[1]), names.value(text_of(right))
    if end.isdecimal():
        return first.isdecimal() and int(first) <= int(end)
    return first == "0" and (right.type in ("sizeof_expression", "offsetof_expression")
                             or (end in names.unsigned and _is_local(right, end)))  # fmt: skip


def _is_local(node: Node, name: str) -> bool:
    """Whether it is a parameter or variable of the function, which is set where it is declared."""
    function = ancestor(node, "function_definition")
    if function is None:
        return False
    return name in dict(_declared(text_of(function))) and not _changes(function, name)


def _changes(inside: Node, name: str) -> int:
    """Count where something is assigned, counted, or may be by its address."""
    fields = {"assignment_expression": "left", "update_expression": "argument",
              "pointer_expression": "argument"}  # fmt: skip
    return sum(
        text_of(node.child_by_field_name(fields[node.type])) == name
        for node in everything(inside) if node.type in fields
    )  # fmt: skip


def text_of(node: Node | None) -> str:
    return node.text.decode() if node is not None and node.text is not None else ""


class Entry(NamedTuple):
    line: int
    pattern: str
    reason: str
    expression: re.Pattern[str]  # matches mutants as the report prints them


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
        expression = re.compile(re.escape(pattern.strip()).translate(MARKS))
        found.append(Entry(number, pattern.strip(), reason.strip(), expression))
    return found


@cache
def listed() -> tuple[Entry, ...]:
    return tuple(entries(LIST.read_text(encoding="utf-8")))


def entry_of(mutants: Iterable[object]) -> Entry | None:
    """Return the entry that one of these fits, which are the same one in several arenas."""
    return next((entry for words in {str(each) for each in mutants} if (entry := _of(words))), None)


@cache
def _of(words: str) -> Entry | None:
    return next((each for each in listed() if each.expression.fullmatch(words)), None)
