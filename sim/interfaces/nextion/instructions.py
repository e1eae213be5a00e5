"""The instructions of a Nextion display, from its serial line and from its pages' events."""

import re
from collections.abc import Callable, Sequence
from operator import eq, ge, gt, le, lt, ne
from typing import Any

from heatwright.sim.interfaces.nextion.codes import Code, Refused
from heatwright.sim.interfaces.nextion.memory import Memory, Part
from heatwright.sim.interfaces.nextion.syntax import Value, expression, name, whole

_ASSIGNMENT = re.compile(r"([A-Za-z][\w.]*)(\+\+|--|[-+*/%]?=)(.*)", re.DOTALL)
_PARAMETER = re.compile(r'(?:"(?:[^"\\]|\\.)*"|[^",])+')
_QUOTED = r'"(?:[^"\\]|\\.)*"'
_COMPARISON = re.compile(rf"((?:{_QUOTED}|[^\"<>=!])+)(==|!=|<=|>=|<|>)((?:{_QUOTED}|[^\"<>=!])+)")
_CONJUNCTION = re.compile(rf"((?:{_QUOTED}|[^\"&|])+)(&&|\|\||$)")
_COMPARED: dict[str, Callable[[Any, Any], bool]] = {
    "==": eq, "!=": ne, "<": lt, ">": gt, "<=": le, ">=": ge,
}  # fmt: skip
_TEXT = "latin-1"
_ALL = 255
"""The component number that means all components in vis and tsw."""


class Instructions:
    """Executes instructions: changes the memory, and sends bytes.

    show -- shows a page by its number; touch -- runs a component's event: press or release.
    """

    def __init__(
        self,
        memory: Memory,
        send: Callable[[bytes], None],
        show: Callable[[int], None],
        touch: Callable[[Part, str], None],
    ) -> None:
        self._memory, self._send, self._show, self._touch = memory, send, show, touch
        self._known: dict[str, tuple[int, Callable[[Sequence[str]], None]]] = {
            "page": (1, self._page),
            "get": (1, self._get),
            "print": (1, self._print),
            "printh": (1, self._print_hex),
            "covx": (4, self._convert),
            "vis": (2, self._visible),
            "tsw": (2, self._touchable),
            "click": (2, self._click),
            "cle": (2, self._clear),
            "add": (3, self._add),
            "ref": (1, self._refresh),
            "sendme": (0, self._send_page),
        }

    def do(self, instruction: str) -> bool:
        """Execute an instruction; return whether it shows a page. Raises Refused."""
        if found := _ASSIGNMENT.fullmatch(instruction):
            self._assign(found[1], found[2], found[3])
            return False
        word, _, rest = instruction.partition(" ")
        if word not in self._known:
            raise Refused(Code.INVALID_INSTRUCTION)
        count, follow = self._known[word]
        given = _PARAMETER.findall(rest) if count > 1 else [rest] * bool(rest)
        if len(given) != count:
            raise Refused(Code.INVALID_QUANTITY)
        follow(given)
        return word == "page"

    def holds(self, condition: str) -> bool:
        """Evaluate a condition, from left to right."""
        holds, joined = False, "||"
        for found in _CONJUNCTION.finditer(condition):
            one = self._compared(found[1])
            holds = (holds and one) if joined == "&&" else (holds or one)
            joined = found[2]
        return holds

    def _compared(self, condition: str) -> bool:
        found = _COMPARISON.fullmatch(condition.strip())
        if found is None:
            raise Refused(Code.INVALID_INSTRUCTION)
        left, right = self._value(found[1].strip()), self._value(found[3].strip())
        ordered = found[2] not in {"==", "!="}
        if type(left) is not type(right) or (ordered and isinstance(left, str)):
            raise Refused(Code.INVALID_OPERATION)
        return _COMPARED[found[2]](left, right)

    def _value(self, text: str) -> Value:
        return self._memory.evaluate(expression(text))

    def _number(self, text: str) -> int:
        value = self._value(text)
        if isinstance(value, str):
            raise Refused(Code.INVALID_OPERATION)
        return value

    def _part(self, text: str) -> Part:
        """Find a component of the shown page by its name or number, also as x.id."""
        asked = expression(text).first
        if isinstance(asked, str):
            raise Refused(Code.INVALID_COMPONENT)
        if not isinstance(asked, int) and len(asked.parts) > 1:
            asked = self._number(text)
        return self._memory.part(asked)

    # -- assignments ---------------------------------------------------------------------------

    def _assign(self, target: str, operator: str, source: str) -> None:
        asked = name(target)
        if operator in {"++", "--"}:
            operator, source = operator[0] + "=", source or "1"
        if operator != "=":
            source = f"{target}{operator[0]}{source}"
        self._memory.set(asked, self._value(source))

    def _convert(self, given: Sequence[str]) -> None:
        """Execute covx: convert number to text, or text to number; length 0: as long as needed."""
        source, target = self._value(given[0]), name(given[1])
        length, form = self._number(given[2]), self._number(given[3])
        if form not in {0, 1, 2} or length < 0:
            raise Refused(Code.INVALID_OPERATION)
        if isinstance(source, str):
            self._memory.set(target, _number_in(source, form, length))
        else:
            self._memory.set(target, _text_of(source, form, length))

    # -- sending -------------------------------------------------------------------------------

    def _get(self, given: Sequence[str]) -> None:
        value = self._value(given[0])
        code = Code.TEXT if isinstance(value, str) else Code.NUMBER
        self._send(code.answer(_bytes_of(value)))

    def _print(self, given: Sequence[str]) -> None:
        self._send(_bytes_of(self._value(given[0])))

    def _print_hex(self, given: Sequence[str]) -> None:
        if not re.fullmatch(r"[0-9A-Fa-f]{2}( [0-9A-Fa-f]{2})*", given[0]):
            raise Refused(Code.INVALID_INSTRUCTION)
        self._send(bytes.fromhex(given[0]))

    def _send_page(self, given: Sequence[str]) -> None:
        del given
        self._send(Code.PAGE.answer(bytes([self._memory.page])))

    # -- display -------------------------------------------------------------------------------

    def _page(self, given: Sequence[str]) -> None:
        asked = expression(given[0]).first
        self._show(self._memory.page_number(asked if not isinstance(asked, str) else -1))

    def _parts(self, text: str) -> Sequence[Part]:
        return tuple(self._memory.shown()) if text == str(_ALL) else (self._part(text),)

    def _visible(self, given: Sequence[str]) -> None:
        for part in self._parts(given[0]):
            part.visible = self._number(given[1]) != 0

    def _touchable(self, given: Sequence[str]) -> None:
        for part in self._parts(given[0]):
            part.touchable = self._number(given[1]) != 0

    def _refresh(self, given: Sequence[str]) -> None:
        """Execute ref: it does nothing, as the picture is always drawn from the memory."""
        self._part(given[0])

    def _click(self, given: Sequence[str]) -> None:
        self._touch(self._part(given[0]), "press" if self._number(given[1]) else "release")

    def _clear(self, given: Sequence[str]) -> None:
        if (waveform := self._part(given[0]).waveform) is None:
            raise Refused(Code.INVALID_WAVEFORM)
        waveform.clear(self._number(given[1]))

    def _add(self, given: Sequence[str]) -> None:
        try:
            waveform = self._part(given[0]).waveform
        except Refused:
            raise Refused(Code.INVALID_WAVEFORM) from None
        if waveform is None:
            raise Refused(Code.INVALID_WAVEFORM)
        waveform.add(self._number(given[1]), self._number(given[2]))


def _bytes_of(value: Value) -> bytes:
    if isinstance(value, str):
        return value.encode(_TEXT, "replace")
    return value.to_bytes(4, "little", signed=True)


def _text_of(number: int, form: int, length: int) -> str:
    """Format a number: decimal, with commas, or hexadecimal; if too long, its last digits."""
    digits = (str(number), f"{number:,}", f"{number % 2**32:X}")[form]
    return digits.rjust(length, "0")[-length:] if length else digits


def _number_in(text: str, form: int, length: int) -> int:
    """Parse a number up to the first other character."""
    text = text[:length] if length else text
    if form == 1:
        text = text.replace(",", "")
    found = re.match(r"[0-9A-Fa-f]+" if form == 2 else r"-?\d+", text)
    return whole(int(found[0], 16 if form == 2 else 10)) if found else 0
