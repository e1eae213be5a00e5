"""Where interrupts come in the C that Eva analyses: at every point where it makes a difference.

Two accesses conflict if they are to one variable and one of them writes. A statement that conflicts
with no interrupt commutes with all of them: an interrupt there does the same as at the next point.
So there is a point before each statement that conflicts with interrupts, before the condition
behind `else`, before the second operand of `&&` and `||`, at the end of each block whose last
statement conflicts, before each `return` of a function that conflicts, and, for all interrupts, in
each turn of an endless loop. Not covered are interrupts between two accesses of one operand, and
between `continue` or the last part of `for` and the loop's condition.

Interrupts that conflict with one another are a group; at a point come the groups that its statement
conflicts with. An access by a pointer is one to all that the pointer may lead to. Before what
enables or disables interrupts there is a point for all groups.
"""

import re
from collections.abc import Iterable, Mapping
from functools import cache
from typing import NamedTuple

from mutation.known import ancestor, everything, name_of, syntax_of, text_of, upwards
from tree_sitter import Node

ATOMIC = re.compile(
    r"^( *)ATOMIC_BLOCK\(ATOMIC_RESTORESTATE\)[^\n]*\n\1\{\n(.*?)^\1\}", re.MULTILINE | re.DOTALL
)
MASKS = r"(?:TIMSK\d?|UCSR\d?B)"
MASK = re.compile(rf"{MASKS}$")
MASK_SET = re.compile(rf"\b({MASKS}) = ")
LATCHED = re.compile(rf"(PORT[A-L]|TCCR\d[AC]|{MASKS})$")  # registers that hold what was written
MASK_BIT = re.compile(r"(OCIE\d?[A-C]?|ADIE|(?:RXC|TXC|UDR)IE[1-9]?)0?$")
SWITCHES = re.compile(rf"(cli|sei|interrupts_on|{MASKS})$")  # by what interrupts come or not
LIBRARY = re.compile(r"mem\w+|str\w+|eeprom_read_block")
"""Functions that take pointers and have no points of their own."""
BYTES = {"uint8_t", "char", "void"}
CAST = re.compile(r"[^*]\((?:const )?((?:struct )?\w+) \*\)")
INLINED = re.compile(r"settings_may_limit_\w+")  # functions that Eva is given as macros
LOOPS = ("for_statement", "while_statement", "do_statement")
JOINED = re.compile(r"(static )?int32_t take_number\(")
"""A function whose loops are looked at with all turns joined: it may begin at any place."""
PLACES = ("field_expression", "subscript_expression", "parenthesized_expression")
HERE = "(interrupts_on ? interrupts_{0}() : (void)0), "  # a point within an expression


class Accesses(NamedTuple):
    """Variables as `name`, and as `file:name` those that only one file knows."""

    reads: frozenset[str] = frozenset()
    writes: frozenset[str] = frozenset()
    switches: bool = False

    def conflict(self, other: "Accesses") -> bool:
        return bool(
            self.switches or self.writes & (other.reads | other.writes) or self.reads & other.writes
        )


class Group(NamedTuple):
    vectors: tuple[str, ...]
    accesses: Accesses


class Firmware:
    """What the files of a firmware declare, by which their accesses are known. A pointer leads to
    what its type says, as no pointer is cast but to bytes (`BYTES`), and a pointer to bytes leads
    anywhere."""

    def __init__(self, sources: Mapping[str, str]) -> None:
        self.functions: dict[str, list[Node]] = {}
        self.lasting: dict[str, str] = {}  # variables that outlive a function, and their types
        self.led_to: dict[str, str] = {}  # of these, what a pointer may lead to
        self._stored: set[str] = set()  # of these, the pointers
        self._arrays: set[str] = set()  # names of arrays, and of members that are arrays
        self._pointers: set[str] = set()  # names of members that are pointers
        self._own: dict[str, set[str]] = {name: set() for name in sources}
        self._files: dict[int, str] = {}
        trees = {name: syntax_of(text.encode()) for name, text in sources.items()}
        for name, tree in trees.items():
            assert set(CAST.findall(sources[name])) <= BYTES, "a pointer is cast"
            for node in everything(tree):
                self._declare(name, node)
        for name, tree in trees.items():  # addresses are in tables, too
            for node in everything(tree):
                key = self._variable(node, name)
                if key in self.lasting and self._way(node, key)[2]:
                    self.led_to[key] = self.lasting[key]
        self._called: set[str] = set()  # by interrupts
        self.groups = self._grouped()

    def shared_functions(self) -> list[str]:
        """Return what both interrupts and others call, and has points."""
        others = [
            text_of(each)
            for name, bodies in self.functions.items()
            for body in bodies
            if name not in self._called
            for each in everything(body)
            if each.type == "identifier"
        ]
        return [
            name
            for name in sorted(self._called & set(others))
            if any(self.met([body], self._files[body.id]) for body in self.functions[name])
        ]

    def accesses(self, nodes: Iterable[Node], file: str, *, inside: bool = False) -> Accesses:
        """Return what parts of a file's functions read and write, by name or through a pointer;
        `inside` a group's functions, an argument leads to what is named there."""
        reads: set[str] = set()
        writes: set[str] = set()
        switches = False
        for node in (each for part in nodes for each in everything(part)):
            text = text_of(node)
            key = self._variable(node, file)
            touched: set[str] = set()
            if node.type == "identifier":
                for body in self.functions.get(text, []) if INLINED.match(text) else []:
                    called = self.accesses([body], self._files[body.id])
                    reads |= called.reads
                    writes |= called.writes
                if LIBRARY.fullmatch(text) and not inside:
                    reads |= set(self.led_to)
                    writes |= set(self.led_to)
                switches = switches or SWITCHES.match(text) is not None
            if key in self.lasting or LATCHED.match(key):
                touched = {key}
            elif (base := _led_by(node)) is not None:
                kind, is_argument = self._pointer(base, file)
                touched = set() if inside and is_argument else self._led_to(kind)
            is_read, is_written, _ = self._way(node, key)
            reads |= touched if is_read else set()
            writes |= touched if is_written else set()
        return Accesses(frozenset(reads), frozenset(writes), switches)

    def met(self, nodes: Iterable[Node], file: str) -> list[int]:
        """Return the groups of interrupts that parts of a file's functions conflict with."""
        found = self.accesses(nodes, file)
        return [n for n, group in enumerate(self.groups) if found.conflict(group.accesses)]

    def _declare(self, file: str, node: Node) -> None:
        if node.type == "function_definition":
            self._declare_function(file, node)
        elif node.type == "field_declaration":
            for each in node.children_by_field_name("declarator"):
                inside = _types(each)
                if "array_declarator" in inside:
                    self._arrays.add(name_of(each))
                if "pointer_declarator" in inside:
                    self._pointers.add(name_of(each))
        elif node.type == "declaration" and (
            text_of(node).startswith("static")
            or not any(each.type == "compound_statement" for each in upwards(node))
        ):
            for each in node.children_by_field_name("declarator"):
                self._declare_variable(file, node, each)

    def _declare_function(self, file: str, node: Node) -> None:
        is_routine = node.children[0].text == b"ISR"
        declared = node.child_by_field_name("declarator")
        name = f"ISR {text_of(node.children[1])}" if is_routine else name_of(declared)
        if re.match(r"static\b(?! inline)", text_of(node)):
            self._own[file].add(name)
            name = f"{file}:{name}"
        body = node.child_by_field_name("body")
        assert body is not None
        self.functions.setdefault(name, []).append(body)
        self._files[body.id] = file

    def _declare_variable(self, file: str, node: Node, declared: Node) -> None:
        inside = _types(declared)
        is_constant = "const" in [text_of(one) for one in node.children]
        is_pointer = "pointer_declarator" in inside
        if "function_declarator" in inside or (is_constant and not is_pointer):
            return
        if text_of(node).startswith("static"):
            self._own[file].add(name_of(declared))
        key = self._key(name_of(declared), file)
        kind = node.child_by_field_name("type")
        self.lasting[key] = text_of(kind).split("{")[0].strip() if kind else ""
        if is_pointer:
            self._stored.add(key)
        if "array_declarator" in inside:
            self._arrays.add(name_of(declared))

    def _key(self, name: str, file: str) -> str:
        return f"{file}:{name}" if name in self._own[file] else name

    def _variable(self, node: Node, file: str) -> str:
        """Return which variable an identifier means; none if it is of the function's own."""
        text = text_of(node)
        if node.type != "identifier" or text in _locals(node):
            return ""
        return self._key(text, file)

    def _pointer(self, base: Node, file: str) -> tuple[str, bool]:
        """Return the type of what a base leads to, and whether it is a pointer of a function's own;
        no type if it is no pointer, and `void` if it is not known where it leads to."""
        while base.type in ("parenthesized_expression", "subscript_expression"):
            base = base.named_children[0]
        if field := base.child_by_field_name("field"):
            return "void" if text_of(field) in self._pointers else "", False
        if base.type != "identifier":
            return "void", False
        name = text_of(base)
        if name in (own := _locals(base)):
            return own[name], True
        key = self._key(name, file)
        return self.lasting[key] if key in self._stored else "", False

    def _led_to(self, kind: str) -> set[str]:
        if kind in BYTES:
            return set(self.led_to)
        return {
            key
            for key, its in self.led_to.items()
            if kind and (its == kind or its.startswith("struct"))  # any may be its member
        }

    def _way(self, node: Node, key: str) -> tuple[bool, bool, bool]:
        """Whether a place is read, whether it is written, and whether a pointer leads to it from
        here on, so that it may be both."""
        is_element = node.type == "subscript_expression"
        name = text_of(node)
        parent = node.parent
        while parent and parent.type in PLACES and parent.children[0] == node:
            is_element = is_element or parent.type == "subscript_expression"
            if field := parent.child_by_field_name("field"):
                name, is_element = text_of(field), False
            node, parent = parent, parent.parent
        if parent is None or parent.type == "sizeof_expression" or _is_declared(node, parent):
            return False, False, False
        sign = text_of(parent.children[0]) if parent.type == "pointer_expression" else ""
        is_array = name in self._arrays and key not in self._stored
        if sign == "&" or (is_array and not is_element):
            return True, True, True
        if parent.type == "assignment_expression" and parent.children[0] == node:
            return text_of(parent.children[1]) != "=", True, False
        return True, parent.type == "update_expression", False

    def _grouped(self) -> tuple[Group, ...]:
        groups: list[Group] = []
        for routine in [name for name in self.functions if name.startswith("ISR ")]:
            vector = routine.removeprefix("ISR ").strip("()")
            new = Group((vector,), self._closure(routine, vector))
            for each in [one for one in groups if new.accesses.conflict(one.accesses)]:
                groups.remove(each)
                both = new.accesses, each.accesses
                new = Group(
                    (*each.vectors, *new.vectors),
                    Accesses(both[0].reads | both[1].reads, both[0].writes | both[1].writes),
                )
            groups.append(new)
        return tuple(groups)

    def _closure(self, routine: str, vector: str) -> Accesses:
        """Return what a routine and all functions that it may call touch, and what enables it: a
        bit, and the bit's register, which is touched only where it is assigned as a whole."""
        timer, uart = re.match(r"TIMER\d", vector), re.match(r"USART\d?", vector)
        reads = {mask_bit(vector)}
        reads |= {"TIMSK", f"TIMSK{timer[0][-1]}"} if timer else set()
        reads |= {"UCSRB", f"UCSR{uart[0][5:] or 0}B"} if uart else set()
        writes: set[str] = set()
        done: set[str] = set()
        new = {routine}
        while new:
            done |= new
            for body in [body for name in new for body in self.functions.get(name, [])]:
                file = self._files[body.id]
                found = self.accesses([body], file, inside=True)
                nodes = [each for each in everything(body) if each.type.endswith("identifier")]
                names = {text_of(each) for each in nodes}
                reads |= {each for each in found.reads if not MASK.match(each)}
                writes |= {each for each in found.writes if not MASK.match(each)}
                writes |= {known[1] for name in names if (known := MASK_BIT.match(name))}
                writes |= set(MASK_SET.findall(text_of(body)))
                if (
                    names & self._pointers
                    or {self._variable(each, file) for each in nodes} & self._stored
                ):
                    reads |= set(self.led_to)
                    writes |= set(self.led_to)
                new = new | {self._key(name, file) for name in names} & set(self.functions)
            new -= done
        self._called |= done
        return Accesses(frozenset(reads - {""}), frozenset(writes))


def mask_bit(vector: str) -> str:
    """Return the name of the bit that enables an interrupt; a first UART's has no number."""
    if found := re.fullmatch(r"TIMER(\d)_COMP([A-C]?)_vect", vector):
        return f"OCIE{found[1]}{found[2]}"
    if found := re.fullmatch(r"USART(\d?)_(RX|TX|UDRE)C?_vect", vector):
        return {"RX": "RXCIE", "TX": "TXCIE", "UDRE": "UDRIE"}[found[2]] + found[1].replace("0", "")
    return {"ADC_vect": "ADIE", "BADISR_vect": ""}[vector]


def unlocked(text: str) -> str:
    """Return a file with its locks written out, and without what its compiler asserts."""

    def written_out(found: re.Match[str]) -> str:
        assert not re.search(r"\b(return|break|continue)\b", found[2]), "it would stay locked"
        return (
            f"{{ const uint8_t were_on = interrupts_on; interrupts_on = 0;\n{found[2]}"
            f"interrupts_on = were_on; }}"
        )

    text = ATOMIC.sub(written_out, re.sub(r"_Static_assert\(.*?\);", "", text, flags=re.DOTALL))
    assert "ATOMIC_BLOCK(" not in text
    return text


def pointed(file: str, text: str, firmware: Firmware, iterations: int) -> str:
    """Return a file with a point for interrupts wherever they matter, and loops unrolled."""

    def points(nodes: Iterable[Node]) -> str:
        return "".join(f"POINT({group}) " for group in firmware.met(nodes, file))

    everywhere = "".join(f"POINT({group}) " for group in range(len(firmware.groups)))
    places: dict[int, str] = {}
    function = root = syntax_of(text.encode())
    for node in everything(root):
        parent = node.parent or node
        if node.type == "function_definition":
            function = node
        if node.type in ("compound_statement", "case_statement"):
            value = node.child_by_field_name("value")
            inner = [each for each in _statements(node) if each != value]
            for each in [] if parent.type == "switch_statement" else inner:
                is_short = _is_short(each) and not JOINED.match(text_of(parent))
                unrolled = f"/*@ loop unroll {iterations}; */ " if is_short else ""
                whole = each.type == "return_statement"
                places[each.start_byte] = points([function] if whole else _own(each)) + unrolled
            if node.type == "compound_statement" and parent.type != "switch_statement":
                last = [parent] if parent.type in LOOPS else inner[-1:]
                is_endless = text_of(parent).startswith("for (;;)")
                places[node.end_byte - 1] = everywhere if is_endless else points(last)
        later = None
        if node.type == "if_statement" and parent.type == "else_clause":
            later = _inner(node.child_by_field_name("condition"))[0]
        elif node.type == "binary_expression" and node.children[1].type in ("&&", "||"):
            later = node.children[2]
        if later is not None and (groups := firmware.met([later], file)):
            here = "".join(HERE.format(group) for group in groups)
            places[later.start_byte] = f"({here}{places.get(later.start_byte, '')}"
            places[later.end_byte] = f"{places.get(later.end_byte, '')})"
    return with_places(text, places)


def with_places(text: str, puts: Mapping[int, str]) -> str:
    data = text.encode()
    for place in sorted(puts, reverse=True):
        data = data[:place] + puts[place].encode() + data[place:]
    return data.decode()


def _types(node: Node) -> set[str]:
    return {each.type for each in everything(node)}


def _inner(node: Node | None) -> list[Node]:
    return node.named_children if node else []


def _locals(node: Node) -> dict[str, str]:
    """Return a function's own names that last no longer, and to what type its pointers lead."""
    function = ancestor(node, "function_definition")
    return _locals_of(function) if function else {}


@cache
def _locals_of(function: Node) -> dict[str, str]:
    found = {}
    for each in everything(function):
        if each.type not in ("declaration", "parameter_declaration"):
            continue
        if text_of(each).startswith("static"):
            continue
        kind = each.child_by_field_name("type")
        for declared in each.children_by_field_name("declarator"):
            is_set = declared.type == "init_declarator"
            inside = _types(declared.children[0] if is_set else declared)
            is_pointer = "pointer_declarator" in inside or (
                each.type == "parameter_declaration" and "array_declarator" in inside
            )
            found[name_of(declared)] = text_of(kind) if kind and is_pointer else ""
    return found


def _led_by(node: Node) -> Node | None:
    """Return by which pointer a place is found, if it is."""
    if node.type == "pointer_expression" and node.children[0].type == "*":
        return node.children[1]
    if node.type == "field_expression" and node.children[1].type == "->":
        return node.children[0]
    if node.type == "subscript_expression":
        return node.children[0]
    return None


def _is_declared(node: Node, parent: Node) -> bool:
    return parent.type == "declaration" or (
        parent.type.endswith("declarator") and parent.children[0] == node
    )


def _is_short(statement: Node) -> bool:
    text = statement.text or b""
    return statement.type in LOOPS and not text.startswith(b"for (;;)") and b"sleep_cpu" not in text


def _statements(block: Node) -> list[Node]:
    return [
        each
        for each in block.named_children
        if each.type != "comment" and not each.type.startswith("preproc")
    ]


def _own(statement: Node) -> list[Node]:
    """The parts of a statement that are no blocks: these have points of their own."""
    if statement.type == "compound_statement":
        return []
    return [each for each in statement.children if each.type != "compound_statement"]
