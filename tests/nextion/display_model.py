"""What a touch display may order, and what its pages show, told from docs/nextion.md; and thousands
of bad orders.
"""

import random
import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from decimal import ROUND_HALF_UP, Decimal

import numpy as np

from heatwright.sim.reference.interfaces.nextion import Editor
from heatwright.sim.reference.programs.copies import FAST, HOLD, OVER, RATE, UNTIL, Copy, Part
from heatwright.spec import Controller, facts_of
from heatwright.spec.nextion import display_pages
from heatwright.spec.nextion.parts import AMBER, FIELD, GREEN

POINTS = 10
NUMBER = re.compile(r"-?([0-9]+\.?[0-9]*|\.[0-9]+)")
WORDS = {OVER: "time", RATE: "K/h", FAST: "fast", HOLD: "hold", UNTIL: "until"}
RUNS = ("runs", "held back", "waits for temperature", "waits for the operator")
STATES = {2: "paused", 3: "returns to its setpoint", 5: "paused by a fault"}
ENDS = ("off", "finished", "stopped", "stopped by a fault")


def segments_of(state: Mapping[str, str]) -> Copy:
    return tuple(Part(*map(int, each.split("/"))) for each in state["points"].split(",")[:-1])


# -- pages


def screens(state: Mapping[str, str], names: Mapping[int, str]) -> dict[str, str]:
    """All attributes that pages are told while a state lasts. names -- of programs, by place."""
    # Product and sum in single precision: an exact half of the last digit may go either way.
    kwh_100 = int(np.float32(state["energy"]) * np.float32(484 / 36e6) + np.float32(0.5))
    fault, letter, duty = int(state["fault"]), "BEJKNRST"[int(state["type"])], state["duty"]
    found: dict[str, object] = {
        "main.temp.val": rounded(state["temperature"]), "main.set.val": rounded(state["target"]),
        "main.duty.val": rounded(duty), "main.programm.val": state["shown"],
        "main.point.val": state["segment"], "main.pname.txt": state["name"],
        "main.state.txt": _state(state), "main.bt1.val": int(state["state"] in "13"),
        "main.energy.txt": f"{Decimal(kwh_100).scaleb(-2)} kWh", "main.ERROR.en": int(fault != 0),
        "main.alarm.txt": f"E{fault:02d}" if fault else "", "points.programm.val": state["shown"],
        "points.pname.txt": state["name"], "settings.sp.txt": rounded(state["setpoint"], 1),
        "settings.crit.txt": rounded(state["maximum"], 1), "settings.type.txt": letter,
        "settings.saves.val": state["saves"], "thermo.type.txt": letter,
        "debug.ot.val": rounded(duty), "debug.t.txt": rounded(state["temperature"], 1),
        "debug.settled.val": rounded(state["settled"]), "debug.over.txt": rounded(state["over"], 1),
        "debug.on.val": state["works"], "debug.sp.txt": rounded(state["target"], 1),
    }  # fmt: skip
    for clock, number in (("clock", ""), ("passed", "2")):
        minutes = int(state[clock]) // 60
        found[f"main.day{number}.val"] = minutes // 1440
        found[f"main.hour{number or 1}.val"] = minutes // 60 % 24
        found[f"main.minute{number or 1}.val"] = minutes % 60
    for gain in ("kp", "ki", "kd"):
        value = Decimal(state[gain])
        places = 6 if value < 10 else 4 if value < 1000 else 2 if value < 100_000 else 0
        found[f"debug.{gain}.txt"] = short(rounded(value, places))
    found |= {f"programs.name{place}.txt": name for place, name in names.items()}
    for row in range(1, POINTS + 1):
        found |= {f"points.{name}": value for name, value in _row(state, row).items()}
    return {name: str(value) for name, value in found.items()}


def _state(state: Mapping[str, str]) -> str:
    number = int(state["state"])
    if number:
        return RUNS[int(state["waiting"])] if number == 1 else STATES[number]
    if state["works"] == "1":
        return "by hand" if state["mode"] == "1" else "on"
    return ENDS[int(state["ended"])]


def _row(state: Mapping[str, str], row: int) -> dict[str, object]:
    runs = state["state"] != "0" and state["number"] == state["shown"]
    running, marked = runs and state["segment"] == str(row), state["marked"] == str(row)
    kind, target, amount = [*segments_of(state), *POINTS * [(0, 0, 0)]][row - 1]
    amounts = {RATE: Decimal(amount) / 10, **dict.fromkeys((OVER, HOLD), Decimal(amount) / 60)}
    return {
        f"p{row}.bco": AMBER if marked else GREEN if running else FIELD,
        f"k{row}.txt": WORDS.get(kind, ""),
        f"m{row}.txt": _amount(kind, rounded(amounts[kind], 2)) if kind in amounts else "",
        f"t{row}.txt": short(Decimal(target) / 10) if kind in (OVER, RATE, FAST) else "",
    }


def _amount(kind: int, amount: Decimal) -> str:
    if kind == RATE:
        return short(amount)
    hours, minutes = divmod(amount, 60)
    return f"{hours}h{'0' * (minutes < 10)}{short(minutes)}"


def rounded(value: str | Decimal, decimals: int = 0) -> Decimal:
    found = Decimal(value).quantize(Decimal(1).scaleb(-decimals), ROUND_HALF_UP)
    return found if found else abs(found)


def short(value: Decimal) -> str:
    return f"{value.normalize():f}"


PLAIN = {12, 16, 17, 18, 22}  # orders with nothing behind their number
LAST_TYPE = 7
MOST_GAIN = 1e6
NASTY = ("", "-", ".", "-.", "..", "1.2.3", "--1", "1-", "+1", "1e3", "0x10", "nan", "inf", "1,5",
         "99999999999999999999", "4294967297", "65537", "-1", "256", "2147483648", " ", "1 ",
         "%s%n", "\\", '"', "½", "\t", "1\0", "A", "1;", "0/0", "   ", " 1", " 1,2,3:", ":", ",,:",
         'a"b', "a\\b", "a" * 13, "ÿ", "\x01", "\x1f", "\x7f", "\r\n",
         "\r\n#", "#", "##")  # fmt: skip
"""What a number or a name is not."""
FILLERS = ("1", "9,9,9:", "a", " ", "0")  # what orders are filled with that are too long
BEYOND = (0, 5, 23, 24, 99, 100, 255, 258, 264, 10**20, 7153.6, -3300, 1100.1, 44641, 42949673)
"""Numbers that are no order's, no kind's, or of no segment."""
EDGES = (-1, -0.5, 0.5, 1, 2, 256, 65536, 2**32)
"""Just outside of what is possible, between two, or what would wrap."""
ALPHABETS = (bytes(range(256)), b"#;0123456789,:. -", b"#;7 1,0:.", b"\xff\x00\x66\x24\x88#;21 ")
"""Bytes that noise is made of: any, and those that come far."""


def noise(chance: random.Random, count: int) -> bytes:
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
        interface, programs = facts_of(controller).nextion, controller.programs
        assert interface is not None
        assert programs is not None
        loop = controller.loops[interface.loop]
        self.setpoints_c = loop.setpoint.minimum_c, loop.setpoint.maximum_c
        self.editor = Editor(controller)
        self.places, self.points = programs.places, programs.points
        self.wholes = {
            2: (0, 1), 8: (1, self.places), 9: (0, 1), 10: (1, self.points), 11: (0, self.points),
            13: (1, self.places), 15: (0, LAST_TYPE), 21: (0, len(display_pages(controller)) - 1),
        }  # fmt: skip
        maximum_c = loop.protection.maximum_c
        self.numbers = {3: self.setpoints_c, 4: (0, 100), 20: (self.setpoints_c[0], maximum_c)}
        self.numbers |= dict.fromkeys((5, 6, 19), (0, MOST_GAIN))

    def allows(self, text: str) -> bool:
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
            return NUMBER.fullmatch(data) is not None and low <= float(data) <= high
        if order == 14:
            return 1 <= len(data) <= 12 and bool(data.strip()) and not set(data) & set('"\\')
        after = None
        with suppress(ValueError):
            after = self.editor.edited(self.points * (Part(UNTIL),), data)
        return order == 7 and after is not None


class Malice:
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
        draw, text = self._chance.choice, self.sound()
        found = draw(list(re.finditer(draw((r"[\d.]+", r"[a-z]+|^\d+", " .*")), text)))
        return f"#{text[: found.start()]}{draw(self._words)}{text[found.end() :]};".encode()
