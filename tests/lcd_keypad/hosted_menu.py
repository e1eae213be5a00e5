"""A menu on this computer: walks through its screens, and what a model says (hosted_menu.c)."""

import random
import struct
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from menu_model import IDLE, LETTERS, PERIOD_MS, POINTS, PROGRAMS, Keypad, Machine, Menu
from rig.firmware import changed, sources_of
from rig.hosted import play, world_of

from heatwright.sim.interfaces.lcd.hd44780 import Hd44780, Times

SPEC = changed(
    "kiln_uno",
    ("    period: 1 s\n", "    period: 2.1 s\n"), ("window: 1 s", "window: 2 s"),
    ("minimum: 0 °C", "minimum: 15 °C"), ("step: 1 K", "step: 2 K"), ("places: 2", "places: 3"),
    ("selectable: [K, S]", "selectable: [K, S, N]"), ("points: 8", "points: 5"),
    ("        - {to: 150 °C, over: 20 min}\n", ""),
)  # fmt: skip
INCLUDED = "#include <stdbool.h>\n#include <stdint.h>\n"
SOURCES = sources_of(SPEC) | {
    "adc.h": f"{INCLUDED}bool adc_is_fresh(void);\nuint8_t adc_upper_bits(void);\n",
    "util/delay.h": "void world_waits(double us);\n#define _delay_us world_waits\n",
}
"""Waits and the ADC are the world's."""
BROKEN = {name for name in SOURCES if name.startswith("menu") and name.endswith(".c")}
BROKEN |= {"panel.c", "keypad.c", "lcd.c"}
WORLD = replace(world_of(
    SPEC, BROKEN | {"text.c"}, Path(__file__).with_suffix(".c"), "-fpack-struct=1",
    "-Wno-address-of-packed-member", "-Dstrcat_P=strcat", "-fno-toplevel-reorder",
    "-fsanitize=undefined", "-fno-sanitize=alignment", "-fno-sanitize-recover=all",
    "-fstack-protector-all", "-D_FORTIFY_SOURCE=2",
), sources=SOURCES)  # fmt: skip

LEVELS = {"right": (0, 14), "up": (15, 49), "down": (50, 99), "left": (100, 149),
          "select": (150, 224), "": (225, 255)}  # fmt: skip
LINE_TICKS = 6
"""Three cells a tick, the second line first; and a tick in which the display is set up again."""
LAST_OF_SET_UP = (0, 0x0), (0, 0x6)
TICK_NS, POWER_UP_TICKS, SET_UP_TICKS = 10_000_000, 6, 3001
"""50 ms and 30 s, each and the tick of it."""
SLOW = Times(power_on=40_000_000, other=41_000, data=41_000)
"""A display with an oscillator of 244 kHz, for which the firmware's 41 us are just enough."""
WAYS = (("", (24, 25, 20, 10, 20, 1)), ("left", (1, 30, 25, 0, 40, 1)),
        ("right right right select select up right", (30, 30, 25, 20, 5, 1)),
        ("right right", (1, 30, 20, 1, 40, 1)), ("", (1, 0, 1, 1, 6, 1)),
        ("right right right select select right", (4, 40, 40, 3, 0, 1)),
        ("right right right select select right right", (4, 40, 40, 3, 0, 1)),
        ("right", (0, 1, 0, 0, 3, 1)),
        ("right right right select", (30, 30, 20, 6, 10, 1)),
        ("left select select select select select", (0, 30, 25, 0, 5, 1)),
        ("right right right select select", (25, 30, 20, 8, 0, 1)))  # fmt: skip
"""Each kind of walk: where it begins, and how often it takes each key."""
EDGES_C = (0.0, -10.4, -0.6, -0.4, 0.4, 0.5, 99.5, 1099.5, 1100.0)
CLOCKS = tuple(
    -(-minutes * 60_000 // PERIOD_MS) - less
    for minutes in (1, 60, 620, 1440, 14_400_000, 14_400_001, 65535 * 1440)
    for less in (0, 1)
)
"""The first step of these minutes, and the last one before it."""
COUNTS = (0, 59, 60, 1300, 8_388_609, 19_999_999, 20_000_001, 2**32 - 1)
GAINS = (0.0, 0.0005, 0.001, 0.00101, 0.00105, 0.00106, 7.5, 9.5e5, 9.6e5, 1e6)
PLACES: dict[str, tuple[str, tuple[Any, ...]]] = {
    "state": ("B", tuple(range(5))), "waiting": ("B", tuple(range(4))),
    "ended": ("B", tuple(range(6))), "segment": ("B", (1, 2, 5)), "segments": ("B", (1, 2, 5)),
    "clock": ("I", CLOCKS), "segment_clock": ("I", CLOCKS), "program_c": ("f", EDGES_C),
    "energy": ("I", COUNTS), "felt_c": ("f", EDGES_C), "has_reading": ("B", (1, 0)),
    "is_on": ("B", (0, 1)),
    "setpoint_c": ("f", (15.0, 16.0, 18.0, 34.0, 36.0, 500.0, 1080.5, 1099.0, 1100.0)),
    "kp": ("f", GAINS), "ki": ("f", GAINS), "kd": ("f", GAINS),
    "maximum_c": ("f", (1150.0, 15.0, 16.0, 18.0, 34.0, 36.0, 500.0, 1130.5, 1149.0)),
    "type": ("B", (3, 0, 4, 6)), "fault": ("B", (0,) * 60 + (*range(1, 27), 255) + (26,) * 8),
    "trips": ("B", (0, 1, 2, 3)),
    "saves": ("I", COUNTS), "is_saved": ("B", (1, 1, 0)), "answer": ("B", (1, 1, 1, 0)),
    "entries_count": ("B", ()), "entries": ("72s", ()), "stored": ("", ()), "is_stored": ("3s", ()),
    "level": ("B", ()), "fresh": ("B", ()),
}  # fmt: skip
"""What is put into the world (hosted_menu.c), in what form, and what is drawn of it."""
DRAWN = [name for name, (_, values) in PLACES.items() if values]


def placed(name: str, value: Any) -> bytes:
    form = PLACES[name][0] or f"{len(value)}s"
    return struct.pack(f"<cB{form}", b"p", list(PLACES).index(name), value)


def program_bytes(name: str, segments: list[tuple[int, int, int]]) -> bytes:
    """Return it as the firmware has it: what is behind an end means nothing."""
    rest = [(0x55, 0x55, 0x55)] * (POINTS - len(segments))
    points = b"".join(struct.pack("<BhI", *each) for each in (*segments, *rest))
    return f"{name}\0".encode().ljust(13, b"U") + bytes([len(segments)]) + points


class Walk:
    """A script, and what is to be seen at each of its looks."""

    def __init__(self, seed: int) -> None:
        self._draw = random.Random(seed)  # noqa: S311 - the same in every run
        way, self._often = WAYS[seed % len(WAYS)]
        self._way = way.split()
        self._machine, self._keypad = Machine(told=[]), Keypad()
        self.script = b""
        self.looks: list[tuple[str, list[str], tuple[str, str]]] = []
        for name in DRAWN:
            self._put(name, PLACES[name][1][0])
        self._put_lists()
        self._menu = Menu(self._machine)
        self._wait(3, "right")  # a key that is down at the start
        self._wait(40, "")
        self._press(*self._way)
        self._stir()
        acts = (self._tap, self._stir, self._hold, self._leave, self._upset, self._keep,
                self._mean, self._acknowledge)  # fmt: skip
        for _ in range(40):
            self._draw.choices(acts, (70, 12, 20, 4, 1, 10 * len(self._way), 6, 6))[0]()

    def _put(self, name: str, value: Any) -> None:
        self.script += placed(name, value)
        setattr(self._machine, name, float(np.float32(value)) if PLACES[name][0] == "f" else value)

    def _put_lists(self) -> None:
        draw, machine = self._draw, self._machine
        machine.stored = [self._program() for _ in range(PROGRAMS)]
        machine.entries = [
            (draw.randint(1, 26), float(np.float32(draw.choice(EDGES_C))), draw.choice(COUNTS))
            for _ in range(draw.choice((0, 1, 7, 8)))
        ]
        entries = b"".join(struct.pack("<BfI", *each) for each in machine.entries)
        self.script += placed("entries_count", len(machine.entries)) + placed("entries", entries)
        stored = b"".join(program_bytes(*(each or ("?", []))) for each in machine.stored)
        self.script += placed("stored", stored)
        self.script += placed("is_stored", bytes(each is not None for each in machine.stored))

    def _wait(self, ticks: int, key: str, fresh: int = 1) -> None:
        self.script += placed("level", self._draw.choice(LEVELS[key])) + placed("fresh", fresh)
        self.script += struct.pack("<cH", b"t", ticks)
        for _ in range(ticks):
            counts = self._keypad.tick(key, fresh)
            self._menu.look()
            if counts:
                self._menu.press(counts, self._keypad.repeats)

    def _look(self, what: str) -> None:
        self.script += b"?"
        self.looks.append((what, self._machine.told, self._menu.shown))
        self._machine.told = []

    def _wait_and_look(self) -> None:
        for what in ("second", "both"):
            self._wait(LINE_TICKS, "")
            self._look(what)

    def _press(self, *keys: str) -> None:
        for key in keys:
            self._wait(2, key)
            self._wait_and_look()

    def _tap(self) -> None:
        key = self._draw.choices(list(LEVELS), self._often)[0]
        self._press(*[key] * self._draw.choice((1, 1, 1, 2, 4)))

    def _hold(self) -> None:
        """For long; a contact that bounces, a key beside it, or a late conversion in between."""
        draw = self._draw
        key = draw.choices(list(LEVELS), (2, 8, 8, 1, 2, 1))[0]
        for _ in range(draw.choice((1, 1, 2, 3))):
            self._wait(draw.choice((1, 3, 49, 50, 51, 61, 241, 251, 260, 400, 800, 2900)), key)
            if draw.random() < 0.5:
                self._wait(draw.choice((1, 2, 60)), key, fresh=0)
            else:
                self._wait(1, draw.choice(list(LEVELS)))
        self._wait_and_look()

    def _leave(self) -> None:
        """Go round to where one came from, or far away from what is edited."""
        self._press(*["left"] * self._draw.choice((5, 5, 30)))

    def _keep(self) -> None:
        self._press("select", "select")
        self._put_lists()
        self._press(*self._way[3:], *["right"] * self._draw.choice((0, 0, 2, 20)))

    def _mean(self) -> None:
        self._press("select")
        self._put("state", self._draw.choice((IDLE, IDLE, 1, 2)))
        self._put("is_saved", self._draw.choice((0, 1)))
        self._refresh()
        self._press("select")

    def _acknowledge(self) -> None:
        draw = self._draw
        self._put("fault", draw.choice((0, 5, 13)))
        self._wait(draw.choice((99, 100, 101, 102, 150)), "")
        self._wait(draw.choice((7, 8, 9, 10, 201, 202, 500, 501, 1001, 1002)), "select", fresh=1)
        self._wait_and_look()

    def _stir(self) -> None:
        draw = self._draw
        for name in ("state", "ended", "segments", "clock", *draw.sample(DRAWN, 5)):
            self._put(name, draw.choice(PLACES[name][1]))
        self._put_lists()
        if draw.random() < 0.7:
            self._refresh()

    def _refresh(self) -> None:
        self.script += b"f"
        self._menu.refresh()
        self._wait_and_look()

    def _program(self) -> tuple[str, list[tuple[int, int, int]]] | None:
        draw = self._draw
        name = "".join(draw.choices(LETTERS + list(" !#[]}~") * 15, k=draw.choice((1, 5, 11, 12))))
        kinds = draw.choices(range(1, 6), k=draw.choice((1, 2, 4, POINTS)))
        segments = [self._segment(kind) for kind in kinds]
        return (name[:1] + name[1:].rstrip(), segments) if draw.random() < 0.8 else None

    def _segment(self, kind: int) -> tuple[int, int, int]:
        most = {1: 2678400, 2: 65535, 4: 2678400}.get(kind, 0)
        fine = 10 if kind == 2 else 60
        amounts = (fine, 2 * fine, 2 * fine - 1, 11 * fine, 12 * fine, most // 2, most - 10 * fine,
                   most - fine, most - 1, most)  # fmt: skip
        targets = (150, 160, 169, 170, 349, 350, 5000, 10801, 10800, 10979, 10980, 10981, 11000)
        target, amount = self._draw.choice(targets), self._draw.choice(amounts)
        return kind, target if kind < 4 else 0, amount if most else 0

    def _upset(self) -> None:
        """One that has missed its place finds it at the next set-up; a cold one, at the second."""
        what, set_ups = self._draw.choice((("cold", 2), ("stray", 1)))
        self._put("fault", 13)  # it fills its line
        self._refresh()
        self._look(what)
        self._wait(set_ups * SET_UP_TICKS + 40, "")
        self._look("both")


@cache
def walks(number: int) -> list[Walk]:
    return [Walk(seed) for seed in range(number)]


class _Display:
    def __init__(self) -> None:
        self.chip, self.upset = Hd44780(SLOW), False
        self._falls, self._set_ups, self._last = list[int](), list[int](), (0, 0)

    def take(self, time_ns: int, rs: int, nibble: int) -> None:
        self._falls.append(time_ns)
        if (self._last, (rs, nibble)) == LAST_OF_SET_UP:
            self._set_ups.append(time_ns // TICK_NS)
        self._last = rs, nibble
        self.chip.write(time_ns, rs, nibble)

    def disturb(self, what: str) -> None:
        """Take it off and put it on again, or give it four bits too many."""
        self.upset = True
        if what == "cold":
            self.chip.power_on(self._falls[-1])
        else:
            self.chip.write(self._falls[-1] + 50_000, 0, 2)

    def problem(self) -> str:
        """Say whether it had its time, and no more of it than it needs."""
        gaps = np.diff(self._falls)
        between = set(np.diff(self._set_ups).tolist())
        if self.chip.lost and not self.upset:
            return f"{self.chip.lost} writes came too early"
        if gaps[0] < 4_100_000 or set(gaps[gaps < 1_000_000].tolist()) != {1000, 41_000}:
            return "the display is given another time than it needs"
        if self._falls[0] // TICK_NS != POWER_UP_TICKS or not self._set_ups:
            return "it is not set up, or not at its time"
        return "" if between <= {SET_UP_TICKS} else f"set up {between}"


def problem_of(world: Path, walk: Walk) -> str:
    display, looks, told = _Display(), iter(walk.looks), list[str]()
    for line in play(world, [walk.script]).decode("latin-1").splitlines():
        if line.startswith(">"):
            display.take(*map(int, line[1:].split()))
        elif line != "?":
            told.append(line)
        else:
            what, orders, shown = next(looks)
            found = display.chip.text[what == "second" :]
            wanted = tuple(text.replace("~", "→") for text in shown)[what == "second" :]
            if told != orders or (what in {"second", "both"} and found != wanted):
                return f"{found} {told} instead of {wanted} {orders}"
            if what in {"cold", "stray"}:
                display.disturb(what)
            told = []
    return "it has said less" if next(looks, None) else display.problem()
