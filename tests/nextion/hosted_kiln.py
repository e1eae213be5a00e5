"""A kiln's firmware on this computer, its display's line in our hands, under gcc's sanitizers."""

import struct
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from rig.firmware import sources_of, spec_of
from rig.hosted import SANITIZED, play, world_of

from heatwright.spec.nextion import display_pages

FOREIGN = {"main.c", "clock.c", "reset.c", "adc.c", "spi_chamber.c", "sensor_chamber.c",
           "checks.c", "cpu.c", "flash.c", "ram.c"}  # fmt: skip
"""What touches the chip: the world stands in for it."""
PACKED = ("-fpack-struct=1", "-Wno-address-of-packed-member", "-fno-common")
"""As the AVR has it: structures give pointers to members at odd addresses."""
WATCHED = ("-fsanitize=undefined,float-cast-overflow", "-fno-sanitize-recover=all",
           "-fstack-protector-all", "-D_FORTIFY_SOURCE=2", "-fno-toplevel-reorder")  # fmt: skip
"""The last: what a library restores begins with what its world defines first (script.h)."""
ANY_PLACE = "-fno-sanitize=alignment"

SPEC = """
heatwright: 1
controller: {name: touched, board: mega2560}
sensors:
  chamber:
    {kind: max31856, chip_select: D10, clock: D52, data_in: D51, data_out: D50, selectable: [K, S]}
outputs:
  element:
    {kind: time_proportional, pin: D2, active: low, window: 1 s, resolution: 10 ms, power: 484 W}
loops:
  chamber:
    {sensor: chamber, heater: element, period: 1 s,
     setpoint: {initial: 20 °C, minimum: 0 °C, maximum: 1100 °C},
     algorithm: {kind: pid, kp: 7.6, ki: 0.026, kd: 51}, response: {within: 3 K, for: 20 s},
     protection: {maximum: 1150 °C, maximum_adjustable: true, minimum: -40 °C, rise_rate: 2000 K/s,
                  heating: off, rising_while_off: off, frozen: off, runaway: off}}
programs:
  loop: chamber
  points: 10
  hold_back: off
  stored:
    - name: fuse
      segments: [{to: 540 °C, over: 60 min}, {hold: 30 min}, {to: 800 °C, at: 150 K/h},
                 {hold: until operator}, {to: 510 °C, at: as fast as possible}]
    - name: slump
      segments: [{to: 600 °C, over: 20 min}]
interfaces:
  - {kind: nextion, loop: chamber}
"""
"""A kiln that no fault stops but those that a test trips."""

FILES = {name for name in sources_of(SPEC) if name.endswith(".c")} - FOREIGN
WORLD = world_of(SPEC, FILES, Path(__file__).with_suffix(".c"), *PACKED, *WATCHED, ANY_PLACE)
GUARDED = replace(WORLD, flags=(*WORLD.flags, *SANITIZED, ANY_PLACE))
"""AddressSanitizer, too, which only a program can have."""
TOUCHED = spec_of(SPEC).controller
PAGE = {page.name: page.id for page in display_pages(TOUCHED)}


def command(letter: str, number: int = 0, data: bytes = b"") -> bytes:
    return struct.pack("<cI", letter.encode(), number & 0xFFFFFFFF) + data


def received(data: bytes) -> bytes:
    return command("r", len(data), data)


def ordered(*orders: str) -> bytes:
    return received("".join(f"#{each};" for each in orders).encode("latin-1"))


def told(text: str) -> bytes:
    """Do an order at once: the next state says whether it was taken."""
    return command("o", len(text), text.encode("latin-1"))


def damaged(data: bytes, error: str = "d") -> bytes:
    return command(error, len(data), data)


def flooded(data: bytes, per_tick: int = 115) -> bytes:
    """Bytes that come in as fast as a line of 115200 baud can carry them."""
    parts = (data[i : i + per_tick] for i in range(0, len(data), per_tick))
    return b"".join(received(part) + command("t", 1) for part in parts)


LETTERS = {"ticks": "t", "celsius": "c", "fault": "f", "trips": "l", "answers": "n", "clock": "w",
           "passed": "m", "steps": "s", "look": "?", "forget": "p",
           "display": "a"}  # fmt: skip
ANSWERS = {"started": b"\0\0\0\xff\xff\xff\x88\xff\xff\xff", "lost": b"\x24\xff\xff\xff"}
"""What the display says by itself."""


def script(text: str) -> bytes:
    """Return what happens, from words between semicolons.

    `5 s` and `5 ticks` let time pass; `order 2 1` and `page main` come from the display, `started`
    and `lost` are its answers; `celsius 20`, `fault 6`; `answers 0` silences the sensor; `clock`,
    `passed` (a program's) and `steps` count on from there; `forget` the gains that are not kept;
    `display 0` no longer answers which page it shows.
    """
    data = b""
    for words in text.split("; "):
        verb, _, rest = words.partition(" ")
        if verb.isdigit():
            data += command("t", int(verb) * (100 if rest == "s" else 1))
        elif verb in LETTERS:
            data += command(LETTERS[verb], int(rest or 0))
        elif verb in ANSWERS:
            data += received(ANSWERS[verb])
        else:
            data += ordered(rest if verb == "order" else f"21 {PAGE[rest]}")
    return data


@dataclass(frozen=True)
class Said:
    """The instructions that were sent, and how things stood at each look."""

    instructions: list[str]
    ticks: list[int]
    """When each was sent."""
    divisors: list[int]
    """The line's divisor at each time."""
    states: list[dict[str, str]]
    counts: list[int]
    """How many instructions came before each look."""

    @property
    def state(self) -> dict[str, str]:
        return self.states[-1]

    @property
    def shown(self) -> dict[str, str]:
        pairs = (line.split("=", 1) for line in self.instructions if "=" in line)
        return {name: value.strip('"') for name, value in pairs}


def run(hosted: Path, *parts: str | bytes) -> Said:
    """Play scripts one after the other; a look at the end is part of it.

    Raises Stopped: the firmware was ended by a sanitizer.
    """
    data = [script(part) if isinstance(part, str) else part for part in parts]
    lines = play(hosted, [*data, script("look")]).decode("latin-1").splitlines()
    states = [_state(line[1:]) for line in lines if line.startswith("=")]
    sent = [line[1:].split(" ", 2) for line in lines if line.startswith(">")]
    looks = [number for number, line in enumerate(lines) if line.startswith("=")]
    counts = [look - before for before, look in enumerate(looks)]
    texts, ticks = [text for *_, text in sent], [int(tick) for tick, *_ in sent]
    divisors = [int(divisor) for _, divisor, _ in sent]
    return Said(texts, ticks, divisors, states, counts)


def order(hosted: Path, *orders: str, before: str = "2 s") -> Said:
    return run(hosted, before, *(ordered(each) + script("2 s; look") for each in orders))


@cache
def _state(line: str) -> dict[str, str]:
    head, _, name_on = line.partition(" name=")
    name, _, points = name_on.rpartition(" points=")
    return dict(pair.split("=", 1) for pair in head.split()) | {"name": name, "points": points}
