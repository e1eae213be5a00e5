"""What a touch display may order, told from its document alone, and thousands of bad orders."""

import random
import re
from collections.abc import Iterator

from display_model import FAST, changed_by, scaled

from heatwright.spec import Controller, nextion_of
from heatwright.spec.nextion import display_pages

PLAIN = {12, 16, 17, 18, 22}
"""Orders with nothing behind their number."""
LAST_TYPE = 7
MOST_GAIN = 1e6
NASTY = ("", "-", ".", "-.", "..", "1.2.3", "--1", "1-", "+1", "1e3", "0x10", "nan", "inf", "1,5",
         "99999999999999999999", "4294967297", "65537", "-1", "256", "2147483648", " ", "1 ",
         "%s%n", "\\", '"', "½", "\t", "1\0", "A", "1;", "0/0", "   ", " 1", " 1,2,3:", ":", ",,:",
         'a"b', "a\\b", "a" * 13, "ÿ", "\x01", "\r\n", "\r\n#", "#", "##")  # fmt: skip
"""What a number or a name is not."""
FILLERS = ("1", "9,9,9:", "a", " ", "0")
"""Of orders that are too long."""
BEYOND = (0, 5, 23, 24, 99, 100, 255, 258, 264, 10**20, 7153.6, -3300, 1100.1, 44641, 42949673)
"""Numbers that are no order's, no kind's, or of no segment."""
EDGES = (-1, -0.5, 0.5, 1, 2, 256, 65536, 2**32)
"""Just outside of what is possible, between two, or what would wrap."""
ALPHABETS = (bytes(range(256)), b"#;0123456789,:. -", b"#;7 1,0:.", b"\xff\x00\x66\x24\x88#;21 ")
"""Bytes that noise is made of: any, and those that come far."""


def noise(chance: random.Random, count: int) -> bytes:
    """Random bytes, from each of the alphabets in turn, sound orders among them."""
    data = bytearray()
    while len(data) < count:
        data += bytes(chance.choices(chance.choice(ALPHABETS), k=chance.randint(1, 500)))
    return bytes(data[:count])


def frames(data: bytes) -> Iterator[str]:
    """What stands between a `#` and the `;` after it, where all of that is printable."""
    inside: bytearray | None = None
    for byte in data:
        if byte == ord("#"):
            inside = bytearray()
        elif inside is not None and byte == ord(";"):
            yield inside.decode()
            inside = None
        elif inside is not None:
            inside = inside + bytes([byte]) if 0x20 <= byte < 0x7F else None


class Grammar:
    """The orders a controller's display may give, in any state it may be in."""

    def __init__(self, controller: Controller) -> None:
        interface, programs = nextion_of(controller), controller.programs
        assert interface is not None
        assert programs is not None
        loop = controller.loops[interface.loop]
        self.setpoints_c = loop.setpoint.minimum_c, loop.setpoint.maximum_c
        self.places, self.points = programs.places, programs.points
        self.wholes = {
            2: (0, 1), 8: (1, self.places), 9: (0, 1), 10: (1, self.points), 11: (0, self.points),
            13: (1, self.places), 15: (0, LAST_TYPE), 21: (0, len(display_pages(controller)) - 1),
        }  # fmt: skip
        maximum_c = loop.protection.maximum_c
        self.numbers = {3: self.setpoints_c, 4: (0, 100), 20: (self.setpoints_c[0], maximum_c)}
        self.numbers |= dict.fromkeys((5, 6, 19), (0, MOST_GAIN))

    def allows(self, text: str) -> bool:
        """Whether an order may be taken."""
        found = re.fullmatch(r"(\d+) ?(.*)", text, re.DOTALL)
        if found is None:
            return False
        order, data = int(found[1]), found[2]
        if not data:
            return order in PLAIN
        if order in self.wholes:
            low, high = self.wholes[order]
            return data.isdigit() and low <= int(data) <= high
        if order in self.numbers:
            low, high = self.numbers[order]
            return scaled(data, 2) is not None and low <= float(data) <= high
        if order == 14:
            return 1 <= len(data) <= 12 and bool(data.strip()) and not set(data) & set('"\\')
        before = ([(FAST, 0, 0)] * count for count in range(self.points + 1))
        return order == 7 and any(changed_by(each, data) is not None for each in before)


class Malice:
    """Makes orders that are none."""

    def __init__(self, grammar: Grammar, seed: int) -> None:
        self._grammar = grammar
        self._chance = random.Random(seed)  # noqa: S311 - no secret
        ends = [*grammar.wholes.values(), *grammar.numbers.values()]
        edges = {end + by for low, high in ends for end in (low, high) for by in EDGES}
        fillers = [filler * count for filler in FILLERS for count in (100, 256, 300)]
        self._words = (*NASTY, *fillers, *map(str, (*BEYOND, *range(23), *sorted(edges))))

    def orders(self, count: int) -> Iterator[bytes]:
        """Bytes in which no order is one that may be taken, whatever comes before or after."""
        made = 0
        while made < count:
            data = self._chance.choice((self._changed, self._replaced, self._replaced))()
            if not any(map(self._grammar.allows, frames(data))):
                made += 1
                yield data

    def noise(self, count: int) -> bytes:
        """Random bytes; a `#` that begins something that may be taken is none any more."""
        data = bytearray(self._chance.randbytes(count))
        while any(map(self._grammar.allows, frames(data))):
            for found in re.finditer(rb"#[ -~]*;", bytes(data)):
                data[found.start()] = ord("$")
        return bytes(data)

    def answers(self, count: int) -> Iterator[bytes]:
        """What a display says of itself, true or not."""
        chance = self._chance
        for _ in range(count):
            yield chance.choice((
                b"\0\0\0", b"\x88", b"\x24", b"\x1a", b"\x66" + chance.randbytes(1), b"",
                b"\x66", b"\x65" + chance.randbytes(3), b"\x71" + chance.randbytes(4),
                b"\x70" + chance.randbytes(40).replace(b"#", b"$"),
            )) + b"\xff" * chance.choice((3, 3, 3, 3, 1, 2, 4, 7))  # fmt: skip

    def sound(self) -> str:
        """An order that may be taken."""
        chance, grammar = self._chance, self._grammar
        order = chance.choice((2, 3, 4, 5, 6, *8 * (7,), 8, 9, 10, 11, 13, 14, 15, 19, 20, 21))
        data = {
            2: "1", 9: "0", 3: f"{chance.uniform(0, 1100):.1f}", 4: f"{chance.uniform(0, 100):.1f}",
            7: self._sound_points(), 14: chance.choice(("fuse", "slump 2", "a-b")),
            20: f"{chance.uniform(500, 1150):.0f}",
        }.get(order, str(chance.randint(1, grammar.places)))  # fmt: skip
        return f"{order} {data}"

    def _sound_points(self) -> str:
        chance = self._chance
        return "".join(
            f"{number},{chance.randint(1, 300)},{chance.randint(20, 1000)}"
            + chance.choice(("", ",0", ",1", ",2", ",4")) + ":"
            for number in range(1, chance.randint(2, 6))
        )  # fmt: skip

    def _changed(self) -> bytes:
        """An order with some of its bytes changed, left out, doubled, or nasty words put in."""
        text = bytearray(f"#{self.sound()};".encode())
        for _ in range(self._chance.randint(1, 4)):
            at = self._chance.randrange(1, len(text))
            match self._chance.randrange(4):
                case 0:
                    text[at] = self._chance.randrange(256)
                case 1:
                    del text[at]
                case 2:
                    text[at:at] = text[at : at + self._chance.randint(1, 9)]
                case _:
                    text[at:at] = self._chance.choice(NASTY).encode()
            text += b";" * (len(text) < 2)
        return bytes(text)

    def _replaced(self) -> bytes:
        """An order of which a number, the name, or all behind its number is something else."""
        draw, text = self._chance.choice, self.sound()
        found = draw(list(re.finditer(draw((r"[\d.]+", r"[a-z]+|^\d+", " .*")), text)))
        return f"#{text[: found.start()]}{draw(self._words)}{text[found.end() :]};".encode()
