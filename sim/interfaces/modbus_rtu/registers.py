"""The registers of a Modbus slave, as docs/modbus.md lists them."""

import struct
from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Literal, NamedTuple

from heatwright.spec import Controller, facts_of

Table = Literal["coil", "discrete_input", "holding_register", "input_register"]
Kind = Literal["bit", "u16", "i16", "u32", "f32"]

BLOCK = 100
"""Loop n has the addresses from n · BLOCK on; the controller has those below BLOCK."""
TENTH, HUNDREDTH = 0.1, 0.01
_CODES: dict[Kind, str] = {"bit": ">H", "u16": ">H", "i16": ">h", "u32": ">I", "f32": ">f"}


class Register(NamedTuple):
    """One value: its address, and its format in words, high word first."""

    table: Table
    address: int
    name: str
    kind: Kind = "u16"
    scale: float = 1.0

    @property
    def words(self) -> int:
        """Number of addresses that it takes."""
        return struct.calcsize(_CODES[self.kind]) // 2

    def value(self, words: Sequence[int]) -> float:
        """Convert words to the value."""
        raw = struct.unpack(_CODES[self.kind], struct.pack(f">{self.words}H", *words))[0]
        return float(raw * self.scale)

    def raw(self, value: float) -> tuple[int, ...]:
        """Convert a value to words."""
        number = value / self.scale
        packed = struct.pack(_CODES[self.kind], number if self.kind == "f32" else round(number))
        return struct.unpack(f">{self.words}H", packed)


def registers(controller: Controller) -> Mapping[str, Register]:
    """Return all registers of a controller by their names, such as `nozzle.setpoint`."""
    found = [*_controller(controller)]
    for number, loop in enumerate(controller.loops, start=1):
        found += [
            each._replace(address=BLOCK * number + each.address, name=f"{loop}.{each.name}")
            for each in _loop(controller, loop)
        ]
    return MappingProxyType({register.name: register for register in found})


def _controller(controller: Controller) -> Iterator[Register]:
    yield Register("coil", 0, "acknowledge", "bit")
    if any(loop.tunable for loop in facts_of(controller).loops.values()):
        yield Register("coil", 1, "store", "bit")
        yield Register("coil", 2, "restore", "bit")
    yield Register("discrete_input", 0, "fault_latched", "bit")
    yield Register("input_register", 0, "map_version")
    yield Register("input_register", 1, "digest", "u32")
    yield Register("input_register", 3, "fault")
    yield Register("input_register", 4, "fault_temperature", "i16", TENTH)
    yield Register("input_register", 5, "fault_time", "u32")
    yield Register("input_register", 7, "uptime", "u32")
    counters = ("messages", "errors", "exceptions", "requests", "unanswered", "overruns")
    for number, name in enumerate(("acknowledgements", *counters)):
        yield Register("input_register", 9 + number, name)
    if controller.monitors:
        yield Register("input_register", 16, "warnings")
    for number, name in enumerate(controller.monitors):
        yield Register("discrete_input", 1 + number, f"warning_{name}", "bit")
        yield Register("input_register", 17 + number, f"monitor_{name}", "i16", TENTH)


def _loop(controller: Controller, name: str) -> Iterator[Register]:
    facts = facts_of(controller, name)
    yield Register("coil", 0, "enabled", "bit")
    for number, state in enumerate(("work", "heat", "cool", "warm", "valid")):
        yield Register("discrete_input", number, state, "bit")
    yield Register("holding_register", 0, "setpoint", "i16", TENTH)
    yield Register("input_register", 0, "temperature", "i16", TENTH)
    yield Register("input_register", 1, "duty", "u16", TENTH)
    yield Register("input_register", 2, "setpoint_in_force", "i16", TENTH)
    yield Register("input_register", 3, "state")
    yield Register("input_register", 4, "reading")
    if facts.current or facts.autotune or facts.response:
        yield Register("input_register", 5, "current", "u16", HUNDREDTH)
    if facts.tunable:
        yield from _tunable()
    if facts.autotune:
        yield Register("coil", 2, "tune", "bit")
    if facts.autotune or facts.response:
        yield Register("input_register", 6, "tuning")
    if facts.response:
        yield Register("input_register", 7, "responses")
        yield Register("input_register", 8, "settling_time", "f32")
        yield Register("input_register", 10, "overshoot", "i16", TENTH)


def _tunable() -> Iterator[Register]:
    yield Register("coil", 1, "manual", "bit")
    yield Register("holding_register", 1, "manual_duty", "u16", TENTH)
    for number, gain in enumerate(("kp", "ki", "kd")):
        yield Register("holding_register", 2 + 2 * number, gain, "f32")
