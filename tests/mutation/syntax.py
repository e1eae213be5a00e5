"""The mutants of one C file, from its syntax tree, each a change of one place; and many in one.

Operators: a statement deleted; a condition negated, made true, made false; relational, arithmetic,
logical and bit operators replaced; a sign or a complement left out; constants + 1, - 1 and 0;
`return`, `break` and `case` removed; `volatile` and atomic blocks removed (`Kind.ORDER`).

In a file of many the variable `chosen_mutant` says which of them it is, 0 for none: `schema`. An
expression e with a mutant m becomes `(chosen_mutant == 17 ? (m) : (e))`, a statement that goes
becomes `if (chosen_mutant != 12) { … }`. The number comes from the environment, before anything
else of the program begins: worlds that keep an image of all memory keep it, too. There is room on
both sides of it: a mutant that writes beside an array must not become another one.
"""

import hashlib
import re
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from enum import Enum
from typing import NamedTuple

from mutation.known import Names, ancestor, can_only_be_equal, name_of, syntax_of, upwards
from tree_sitter import Node


class Kind(Enum):
    """How a mutant can be put beside the original in one file (`schema`)."""

    EXPRESSION = "expression"
    CONDITION = "condition"
    """An expression of which only the truth counts."""
    STATEMENT = "statement"
    ALONE = "alone"
    """Not at all: the compiler asks for a constant there."""
    SAME = "same"
    """It can only be equal (`known`): where one firmware shows that, it is judged in none."""
    ORDER = "order"
    """Not at all, and only a processor that is interrupted can tell it from the original."""


class Mutant(NamedTuple):
    file: str
    function: str
    """Where it is; empty outside of functions."""
    start: int
    end: int
    """The bytes that are replaced begin at `start`, and end before `end`."""
    new: str
    kind: Kind
    what: str
    """Statement or condition before and after it, on one line; unique in its function."""
    identity: str
    """The same for the same change of the same statement, in whatever variant of its function: it
    is one line of one template."""

    def applied(self, text: str) -> str:
        data = text.encode()
        return (data[: self.start] + self.new.encode() + data[self.end :]).decode()

    def __str__(self) -> str:
        return f"{self.file} {self.function or '-'}: {self.what}"


OPERATORS: dict[str, tuple[str, ...]] = {
    "<": ("<=", "!="), ">": (">=", "!="), "<=": ("<", "=="), ">=": (">", "=="),
    "==": ("<=", ">=", "!="), "!=": ("<", ">", "=="),
    "+": ("-",), "-": ("+",), "*": ("/",), "/": ("*",), "%": ("*",),
    "&&": ("||",), "||": ("&&",),
    "&": ("|",), "|": ("&",), "^": ("|",), "<<": (">>",), ">>": ("<<",),
    "+=": ("-=", "="), "-=": ("+=", "="), "*=": ("/=", "="), "/=": ("*=", "="), "%=": ("=",),
    "|=": ("&=", "="), "&=": ("|=", "="), "^=": ("|=",), "<<=": (">>=",), ">>=": ("<<=",),
    "++": ("--",), "--": ("++",),
}  # fmt: skip
"""Those of a comparison are, with true and false, what every test of it has to tell apart."""
RELATIONAL, LOGICAL = ("<", ">", "<=", ">=", "==", "!="), {"&&": "1", "||": "0"}
BLOCKS = ("compound_statement", "case_statement")
LONG_TABLE = 8
"""Constants of an initialiser: of a longer one the first, the middle and the last are changed."""
SKIPPED = ("comment", "string_literal", "sizeof_expression", "type_descriptor", "ERROR",
           "preproc_include", "preproc_def", "preproc_function_def", "preproc_call")  # fmt: skip
_ATOMIC = re.compile(rb"ATOMIC_BLOCK\(\w+\)")
_INTEGER = re.compile(r"(0[xX][0-9a-fA-F]+|\d+)([uUlL]*)")


def mutants_of(
    file: str, text: str, names: Names, loops: Sequence[str] = (), *, order: bool = False
) -> list[Mutant]:
    """Return the mutants of a file of a firmware, which declares and defines names; those of its
    loops make a line no other one. `order`: with those that only interruptions can tell."""
    found = _File(file, text, names, loops).mutants()
    return found if order else [each for each in found if each.kind is not Kind.ORDER]


class _File:
    def __init__(self, file: str, text: str, names: Names, loops: Sequence[str]) -> None:
        self._file, self._data, self._names = file, text.encode(), names
        self._loops = loops
        self._seen: Counter[tuple[str, str]] = Counter()
        self._found: dict[tuple[int, int, str], tuple[Node, Kind]] = {}

    def mutants(self) -> list[Mutant]:
        root = syntax_of(_ATOMIC.sub(lambda found: b" " * len(found[0]), self._data))
        self._visit(root, constant=True)  # outside of functions, all are
        for found in _ATOMIC.finditer(self._data):
            inside = root.descendant_for_byte_range(found.start(), found.start())
            assert inside is not None
            self._add(inside, "", Kind.ORDER, found.start(), found.end())
        places = sorted(self._found.items(), key=lambda item: item[0])
        return [self._mutant(place, *found) for place, found in places]

    def _mutant(self, place: tuple[int, int, str], node: Node, kind: Kind) -> Mutant:
        start, end, new = place
        function = ancestor(node, "function_definition")
        name, what = name_of(function), self._words(node, start, end, new)
        self._seen[name, what] += 1
        if self._seen[name, what] > 1:
            what += f" ({self._seen[name, what]})"
        told = self._without_names(repr((self._file, name, self._way_to(node), what)))
        identity = hashlib.sha256(told.encode()).hexdigest()[:24]
        return Mutant(self._file, name, start, end, new, kind, what, identity)

    def _without_names(self, text: str) -> str:
        for loop in self._loops:
            text = re.sub(rf"(?<![A-Za-z])(?:{loop}|{loop.upper()})(?![a-z])", "LOOP", text)
        return text

    def _way_to(self, node: Node) -> list[str]:
        """The statements that a place is inside of, by what decides in each."""
        way = []
        for around in upwards(node):
            found = around.child_by_field_name("condition") or around.child_by_field_name("value")
            if around.type.endswith("_statement") and found is not None:
                way.append(f"{around.type} {_line(found.text or b'')}")
            elif around.type == "else_clause":
                way.append("else")
        return way

    def _words(self, node: Node, start: int, end: int, new: str) -> str:
        around = node
        while around.parent is not None and around.parent.type not in (
            "compound_statement", "case_statement", "if_statement", "for_statement", "do_statement",
            "while_statement", "switch_statement", "function_definition", "translation_unit",
            "initializer_list", "enumerator_list",
        ):  # fmt: skip
            around = around.parent
        first, last = min(around.start_byte, start), max(around.end_byte, end)
        if around.type in (*BLOCKS, "function_definition"):
            first, last = start, end
        before = self._data[first:start], self._data[start:end], self._data[end:last]
        word = (around.parent.children[0].text or b"") + b" " if (
            around.type == "parenthesized_expression" and around.parent is not None
        ) else b""  # fmt: skip
        old = _line(word + b"".join(before))
        now = _line(word + before[0] + new.encode() + before[2])
        return f"{old} -> {now or 'nothing'}"

    def _add(
        self, node: Node, new: str, kind: Kind, start: int | None = None, end: int | None = None
    ) -> None:
        start = node.start_byte if start is None else start
        end = node.end_byte if end is None else end
        if self._data[start:end].decode() != new:
            self._found.setdefault((start, end, new), (node, kind))

    # ---- the walk ----

    def _visit(self, node: Node, *, constant: bool) -> None:
        if node.type in SKIPPED:
            return
        inside = _parent_type(node) == "function_definition" and node.type == "compound_statement"
        constant = not inside and (constant or _needs_constant(node))
        kind = Kind.ALONE if constant else Kind.EXPRESSION
        for new in self._replacements(node):
            self._add(node, new, kind)
        self._statement(node)
        for part in _conditions(node):
            self._condition(part, constant=constant, repeats=node.type != "if_statement")
        numbers = [child for child in node.children if child.type in ("number_literal", "{")]
        children = node.children
        if node.type == "initializer_list" and len(numbers) + len(children) > 2 * LONG_TABLE:
            entries = node.named_children
            children = [entries[0], entries[len(entries) // 2], entries[-1]]
        for child in children:
            self._visit(child, constant=constant)

    def _condition(self, node: Node, *, constant: bool, repeats: bool) -> None:
        kind, text = Kind.ALONE if constant else Kind.CONDITION, self._text(node)
        if node.type == "number_literal" or text in ("true", "false"):
            return
        self._add(node, f"!({text})", kind)
        self._add(node, "0", kind)
        if not repeats or _parent_type(node) == "conditional_expression":
            self._add(node, "1", kind)

    def _statement(self, node: Node) -> None:
        if node.type == "case_statement":
            colon = next(child for child in node.children if child.type == ":")
            self._add(node, "", Kind.ALONE, node.start_byte, colon.end_byte)
        elif node.type == "type_qualifier" and self._text(node) == "volatile":
            self._add(node, "", Kind.ORDER)
        elif _may_go(node) and not re.fullmatch(r"\(void\)\w+;", self._text(node)):
            self._add(node, ";" if _parent_type(node) not in BLOCKS else "",
                      Kind.STATEMENT)  # fmt: skip

    def _replacements(self, node: Node) -> Iterator[str]:
        if node.type in ("binary_expression", "assignment_expression", "update_expression"):
            yield from self._other_operators(node)
        elif node.type == "unary_expression":
            inner = node.child_by_field_name("argument")
            assert inner is not None
            yield f"({self._text(inner)})"
        elif node.type in ("true", "false"):
            yield {"true": "false", "false": "true"}[node.type]
        elif node.type in ("number_literal", "identifier", "char_literal") and not _is_name(node):
            yield from self._other_numbers(node)

    def _other_operators(self, node: Node) -> Iterator[str]:
        operator = node.child_by_field_name("operator")
        if operator is None:
            return
        sign, start = self._text(operator), node.start_byte
        text = self._data[start : node.end_byte]
        before = text[: operator.start_byte - start].decode()
        after = text[operator.end_byte - start :].decode()
        if node.type == "update_expression" and _parent_type(node) == "for_statement":
            return  # it would not end, or at once
        for other in OPERATORS.get(sign, ()):
            if {sign, other} == {"==", "!="} and _decides(node):
                continue  # it is negated already
            if sign in RELATIONAL and can_only_be_equal(node, other, self._names):
                self._add(node, f"{before}{other}{after}", Kind.SAME)
                continue
            yield f"{before}{other}{after}"
        if sign in RELATIONAL:
            yield "1" if "=" in sign and sign != "==" else "0"
        if sign in LOGICAL:  # as if one side were not there
            yield before.rstrip()
            yield after.lstrip()

    def _other_numbers(self, node: Node) -> Iterator[str]:
        text = self._text(node)
        whole = _INTEGER.fullmatch(text)
        if whole:
            value, suffix = int(whole[1], 0 if whole[1][:1] != "0" else 16), whole[2]
            yield f"{value + 1}{suffix}"
            if value or not suffix:
                yield f"{value - 1}{suffix}" if value else "(-1)"
            if value:
                yield f"0{suffix}"
        elif node.type == "number_literal":
            yield from (f"({text} + 1.0f)", f"({text} - 1.0f)")
            if float(text.rstrip("fF")):
                yield "0.0f"
        elif node.type == "char_literal" or text in self._names.constants:
            yield f"({text} + 1)"
            yield f"({text} - 1)"
            if self._names.value(text) not in ("0", "1", "0.0"):  # of 1, 0 is one less
                yield "0"

    def _text(self, node: Node) -> str:
        return self._data[node.start_byte : node.end_byte].decode()


def _conditions(node: Node) -> list[Node]:
    if node.type not in ("if_statement", "while_statement", "do_statement", "for_statement",
                         "conditional_expression"):  # fmt: skip
        return []
    found = node.child_by_field_name("condition")
    while found is not None and found.type == "parenthesized_expression":
        found = next(iter(found.named_children), None)
    return [found] if found is not None else []


def _decides(node: Node) -> bool:
    parent = node.parent
    while parent is not None and parent.type == "parenthesized_expression":
        parent = parent.parent
    return parent is not None and any(each.id == node.id for each in _conditions(parent))


def _needs_constant(node: Node) -> bool:
    """Whether the compiler asks for a constant here, inside of a function."""
    parent = node.parent
    if parent is None:
        return False
    if parent.type == "init_declarator" and parent.child_by_field_name("value") == node:
        around = ancestor(node, "declaration")
        assert around is not None
        return any(child.text == b"static" for child in around.children)
    field = {"enumerator": "value", "array_declarator": "size", "case_statement": "value"}
    wanted = field.get(parent.type)
    return wanted is not None and parent.child_by_field_name(wanted) == node


def _is_name(node: Node) -> bool:
    """Whether it is what a declaration or a directive gives a name."""
    parent = node.parent
    assert parent is not None
    return _parent_type(node).startswith("preproc") or parent.child_by_field_name("name") == node


def _may_go(node: Node) -> bool:
    """Whether a statement can be left out; a value that a function ends with cannot."""
    if node.type == "return_statement" and node.named_children:
        block = node.parent
        last = block is not None and block.type == "compound_statement" and (
            block.named_children[-1] == node
        )  # fmt: skip
        return not (last and _parent_type(block) == "function_definition")
    return node.type in (
        "expression_statement", "return_statement", "break_statement", "continue_statement",
    ) and bool(node.named_children or node.type != "expression_statement")  # fmt: skip


def _parent_type(node: Node | None) -> str:
    return node.parent.type if node is not None and node.parent is not None else ""


def _line(text: bytes) -> str:
    return " ".join(re.sub(r"/\*.*?\*/", "", text.decode(), flags=re.DOTALL).split())


VARIABLE = "MUTANT"
NAMED = "#define chosen_mutant chosen_mutants[64]\n"
DECLARATION = "extern volatile int chosen_mutants[128];\n" + NAMED
DEFINITION = f"""\
volatile int chosen_mutants[128];
{NAMED}char *getenv(const char *);
int atoi(const char *);
__attribute__((constructor(101))) static void choose_mutant(void)
{{
    const char *const number = getenv("{VARIABLE}");

    chosen_mutant = number ? atoi(number) : 0;
}}
"""
Place = tuple[int, int]
TOGETHER = (Kind.EXPRESSION, Kind.CONDITION, Kind.STATEMENT)


def schema(text: str, mutants: Mapping[int, Mutant], *, defines: bool = False) -> str:
    """Return a file with all these mutants in it, by their numbers from 1 on; one file of a program
    defines the variable."""
    places: dict[Place, list[int]] = defaultdict(list)
    for number, mutant in mutants.items():
        places[mutant.start, mutant.end].append(number)
    ordered = sorted(places, key=lambda place: (place[0], -place[1]))
    body = _Text(text.encode(), mutants, places).part(0, len(text.encode()), ordered)
    return (DEFINITION if defines else DECLARATION) + "#line 1\n" + body.decode()


class _Text:
    def __init__(
        self, data: bytes, mutants: Mapping[int, Mutant], places: Mapping[Place, Sequence[int]]
    ) -> None:
        self._data, self._mutants, self._places = data, mutants, places

    def part(self, start: int, end: int, places: Sequence[Place]) -> bytes:
        """Return a part of the file with its places, which are ordered, the outer ones first."""
        found, here, rest = [], start, list(places)
        while rest:
            first, last = rest.pop(0)
            inner = [place for place in rest if place[1] <= last]
            rest = rest[len(inner) :]
            found += [self._data[here:first], self._chosen(first, last, inner)]
            here = last
        return b"".join([*found, self._data[here:end]])

    def _chosen(self, start: int, end: int, inner: Sequence[Place]) -> bytes:
        plain = self.part(start, end, inner)
        numbers = self._places[start, end]
        kinds = {self._mutants[number].kind for number in numbers}
        if kinds == {Kind.STATEMENT}:
            (number,) = numbers
            return b"{ if (chosen_mutant != %d) { %s } }" % (number, plain)
        if Kind.CONDITION in kinds:
            plain = b"!!(%s)" % plain
        for number in numbers:
            new = self._mutants[number].new.encode()
            plain = b"(chosen_mutant == %d ? (%s) : (%s))" % (number, new, plain)
        return plain
