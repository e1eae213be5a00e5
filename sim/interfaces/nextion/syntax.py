"""The syntax of Nextion instructions: numbers, texts, names and expressions."""

import re
from dataclasses import dataclass
from functools import lru_cache

from heatwright.sim.interfaces.nextion.codes import LONGEST_NAME, Code, Refused

Value = int | str

REMEMBERED = 1024
"""Parsed texts to cache: a board sends the same ones again and again."""

_WORD = re.compile(
    r'(?P<text>"(?:[^"\\]|\\.)*")|(?P<number>0x[0-9A-Fa-f]+|\d+)|(?P<name>[A-Za-z]\w*(?:\.\w+)*)'
    r"|(?P<operator>[-+*/%])"
)
_ESCAPE = re.compile(r"\\(.)")
_ESCAPES = {"r": "\r\n", '"': '"', "\\": "\\"}


@dataclass(frozen=True)
class Name:
    """A variable or an attribute: dim, b0.txt, main.b0.txt."""

    parts: tuple[str, ...]


@dataclass(frozen=True)
class Expression:
    """Operands and operators, evaluated strictly from left to right."""

    first: Value | Name
    rest: tuple[tuple[str, Value | Name], ...] = ()


@lru_cache(maxsize=REMEMBERED)
def expression(text: str) -> Expression:
    """Parse an expression. Raises Refused."""
    operands: list[Value | Name] = []
    operators: list[str] = []
    place, sign = 0, 1
    while place < len(text):
        found = _WORD.match(text, place)
        if found is None:
            raise Refused(Code.INVALID_VARIABLE)
        place = found.end()
        due = len(operands) == len(operators)
        if found.lastgroup != "operator":
            if not due:
                raise Refused(Code.INVALID_INSTRUCTION)
            operands.append(_operand(found, sign))
            sign = 1
        elif due:
            sign = _sign(found[0], sign)
        else:
            operators.append(found[0])
    if not operands or len(operands) == len(operators):
        raise Refused(Code.INVALID_INSTRUCTION)
    return Expression(operands[0], tuple(zip(operators, operands[1:], strict=True)))


@lru_cache(maxsize=REMEMBERED)
def name(text: str) -> Name:
    """Parse a name. Raises Refused."""
    found = _WORD.fullmatch(text)
    if found is None or found.lastgroup != "name":
        raise Refused(Code.INVALID_VARIABLE)
    return _name(text)


def whole(value: int) -> int:
    """Wrap a number to 32 bits, as the display does."""
    return (value + 2**31) % 2**32 - 2**31


def _operand(found: re.Match[str], sign: int) -> Value | Name:
    if found.lastgroup == "number":
        return whole(sign * int(found[0], 0 if found[0].startswith("0x") else 10))
    if sign < 0:
        raise Refused(Code.INVALID_OPERATION)
    return _text(found[0][1:-1]) if found.lastgroup == "text" else _name(found[0])


def _sign(operator: str, sign: int) -> int:
    """Return the sign −1 for a minus before a number; refuse anything else."""
    if operator != "-" or sign < 0:
        raise Refused(Code.INVALID_INSTRUCTION)
    return -1


def _text(raw: str) -> str:
    def unescaped(found: re.Match[str]) -> str:
        if found[1] not in _ESCAPES:
            raise Refused(Code.INVALID_ESCAPE)
        return _ESCAPES[found[1]]

    return _ESCAPE.sub(unescaped, raw)


def _name(text: str) -> Name:
    parts = tuple(text.split("."))
    if any(len(part) > LONGEST_NAME for part in parts):
        raise Refused(Code.NAME_TOO_LONG)
    return Name(parts)
