"""A kiln's firmware on this computer, its display's line in our hands, under gcc's sanitizers."""

import struct
import subprocess
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import heatwright.sim.host

WORLD = Path(__file__).parent / "touch_world"
INCLUDE = Path(heatwright.sim.host.__file__).parent / "include"
FLAGS = [
    "-std=c11", "-g", "-O1", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off",
    "-fpack-struct=1", "-Wno-address-of-packed-member", "-fno-common",
    "-fsanitize=address,undefined,float-cast-overflow,float-divide-by-zero",
    "-fno-sanitize=alignment", "-fno-sanitize-recover=all",
    "-D__AVR_ATmega2560__", "-DF_CPU=16000000UL",
]  # fmt: skip
FOREIGN = ("main.c", "clock.c", "reset.c", "adc.c", "spi_chamber.c", "sensor_chamber.c")
"""What touches the chip: the world stands in for it."""

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
    sensor: chamber
    heater: element
    period: 1 s
    setpoint: {initial: 20 °C, minimum: 0 °C, maximum: 1100 °C}
    algorithm: {kind: pid, kp: 7.6, ki: 0.026, kd: 51}
    protection:
      maximum: 1150 °C
      maximum_adjustable: true
      minimum: -40 °C
      rise_rate: 2000 K/s
      heating: off
      rising_while_off: off
      frozen: off
      runaway: off
programs:
  loop: chamber
  points: 10
  hold_back: off
  stored:
    - name: fuse
      segments:
        - {to: 540 °C, over: 60 min}
        - {hold: 30 min}
        - {to: 800 °C, at: 150 K/h}
        - {hold: until operator}
        - {to: 510 °C, at: as fast as possible}
    - name: slump
      segments: [{to: 600 °C, over: 20 min}]
interfaces:
  - {kind: nextion, loop: chamber}
"""
"""A kiln that no fault stops but those that a test trips."""


def compile_kiln(files: Mapping[str, str], folder: Path) -> dict[str, Path]:
    """Compile what of a project touches no chip, and the world; objects by their sources' names."""
    for path, text in files.items():
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")
    sources = [*(folder / "src").glob("*.c"), WORLD / "world.c"]
    mine = [source for source in sources if source.name not in FOREIGN]
    with ThreadPoolExecutor() as pool:
        objects = pool.map(lambda source: compiled(source, folder), mine)
    return dict(zip((source.name for source in mine), objects, strict=True))


def compiled(
    source: Path, folder: Path, project: Path | None = None, *, strict: bool = True
) -> Path:
    """Compile one source; project -- where its headers are, if elsewhere."""
    made = folder / f"{source.stem}.o"
    flags = FLAGS if strict else [*FLAGS, "-w"]
    includes = [f"-I{WORLD}", f"-I{INCLUDE}", f"-I{(project or folder) / 'src'}"]
    subprocess.run(["gcc", *flags, *includes, "-c", source, "-o", made], check=True)
    return made


def linked(objects: Mapping[str, Path], program: Path) -> Path:
    """Make a program of objects."""
    subprocess.run(["gcc", *FLAGS, *objects.values(), "-lm", "-o", program], check=True)
    return program


def received(data: bytes) -> bytes:
    """Bytes that come in, at once."""
    return b"r" + struct.pack("<H", len(data)) + data


def damaged(data: bytes) -> bytes:
    """The same, a byte with a framing error before them."""
    return b"d" + struct.pack("<H", len(data)) + data


def flooded(data: bytes, per_tick: int = 115) -> bytes:
    """Bytes that come in as fast as a line of 115200 baud can carry them."""
    parts = (data[i : i + per_tick] for i in range(0, len(data), per_tick))
    return b"".join(received(part) + ticks(1) for part in parts)


def ticks(count: int) -> bytes:
    return b"t" + struct.pack("<H", count)


def seconds(count: int) -> bytes:
    return ticks(100 * count)


def celsius(value: int) -> bytes:
    return b"c" + struct.pack("<h", value)


def fault(code: int) -> bytes:
    return b"f" + bytes([code])


LOOK = b"?"
FORGET = b"p"
"""Of the gains those that are not kept."""
SILENT = b"n\0"
ANSWERS = b"n\1"
STARTED = b"\0\0\0\xff\xff\xff\x88\xff\xff\xff"


@dataclass(frozen=True)
class Said:
    """The instructions that were sent, and how things stood at each look."""

    instructions: list[str]
    ticks: list[int]
    """When each was sent."""
    states: list[dict[str, str]]

    @property
    def state(self) -> dict[str, str]:
        """At the last look."""
        return self.states[-1]

    @property
    def shown(self) -> dict[str, str]:
        """The last value of every attribute."""
        pairs = (line.split("=", 1) for line in self.instructions if "=" in line)
        return {name: value.strip('"') for name, value in pairs}


class Broken(AssertionError):
    """The firmware was ended by a sanitizer."""


def run(program: Path, *script: bytes) -> Said:
    """Play a script; a look at the end is part of it."""
    data = b"".join(script) + LOOK
    done = subprocess.run([program], input=data, capture_output=True, check=False, timeout=60)
    if done.returncode:
        raise Broken(done.stderr.decode(errors="replace"))
    lines = done.stdout.decode("latin-1").splitlines()
    states = [_state(line[1:]) for line in lines if line.startswith("=")]
    sent = [line[1:].split(" ", 1) for line in lines if line.startswith(">")]
    return Said([text for _, text in sent], [int(tick) for tick, _ in sent], states)


def order(program: Path, *orders: str, before: Sequence[bytes] = ()) -> Said:
    """Give orders one by one, each with time for what it does, after a second of peace."""
    script = [seconds(2), *before]
    for each in orders:
        script += [received(f"#{each};".encode("latin-1")), seconds(2), LOOK]
    return run(program, *script)


def _state(line: str) -> dict[str, str]:
    head, _, name_on = line.partition(" name=")
    name, _, points = name_on.rpartition(" points=")
    return dict(pair.split("=", 1) for pair in head.split()) | {"name": name, "points": points}
