"""The register map of a Modbus slave, from which C, Markdown, CSV and client are generated.

Addresses count from 0, as in the frames. The controller's block begins at 0, the loops' blocks at
100, 200 and so on, in the order of the file. A block has no gaps: a register for a feature that a
loop lacks reads 0 if registers follow behind it.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, get_args

from heatwright.spec import Controller, Spec, facts_of
from heatwright.spec.algorithms import LARGEST_GAIN

VERSION = 1
"""Version of the register map: it changes when the meaning of an address changes."""
BLOCK = 100
NO_TEMPERATURE = -32768
"""Value of a temperature register before the first good reading."""
STATE_FAULT, STATE_VALID = 16, 32
"""Bits of a loop's state in addition to those of state.h."""

Table = Literal["coils", "discretes", "holdings", "inputs"]
TABLES: tuple[Table, ...] = get_args(Table)
Kind = Literal["bit", "u16", "i16", "u32", "f32"]
Access = Literal["read", "read, write"]


@dataclass(frozen=True, slots=True)
class Stored:
    """Where the firmware stores a value; how -- MAP_* of modbus_map.h, or the mask of a bit."""

    how: str
    place: str
    """A C expression; for MAP_NUMBER the number itself."""


@dataclass(frozen=True, slots=True)
class Register:
    """One value of the map: a bit, one word or two words."""

    table: Table
    address: int
    name: str
    """Name, such as `nozzle.temperature`; names of the controller's registers have no dot."""
    kind: Kind
    meaning: str
    stored: Stored
    access: Access = "read"
    scale: float = 1.0
    """Value of one step, in `unit`."""
    unit: str = ""
    minimum: float | None = None
    maximum: float | None = None

    @property
    def words(self) -> int:
        """Number of addresses that it takes; of two words, the first is the high one."""
        return 2 if self.kind in {"u32", "f32"} else 1


@dataclass(frozen=True, slots=True)
class RegisterMap:
    """All registers, in the order of tables and addresses."""

    digest: str
    registers: tuple[Register, ...]

    def table(self, name: Table) -> tuple[Register, ...]:
        """Return the registers of one table."""
        return tuple(each for each in self.registers if each.table == name)


def register_map(spec: Spec) -> RegisterMap:
    """Make the map of a spec."""
    registers = [*_controller(spec)]
    for number, name in enumerate(spec.controller.loops, start=1):
        registers += _loop(spec.controller, name, BLOCK * number)
    registers.sort(key=lambda each: (TABLES.index(each.table), each.address))
    return RegisterMap(spec.digest, tuple(registers))


def _byte(address: int, name: str, meaning: str, place: str) -> Register:
    return Register("inputs", address, name, "u16", meaning, Stored("MAP_BYTE", f"&{place}"))


def _seconds(address: int, name: str, meaning: str, place: str) -> Register:
    stored = Stored("MAP_WORD", f"&{place}")
    return Register("inputs", address, name, "u32", meaning, stored, unit="s")


def _celsius(
    address: int, name: str, meaning: str, stored: Stored, table: Table = "inputs"
) -> Register:
    return Register(table, address, name, "i16", meaning, stored, scale=0.1, unit="°C")


def _controller(spec: Spec) -> Iterable[Register]:
    yield from _coils_of_controller(spec.controller)
    yield Register(
        "discretes", 0, "fault_latched", "bit", "A fault is latched: all heaters are off.",
        Stored("0xFF", "&fault.code"),
    )  # fmt: skip
    yield from _warnings(spec.controller)
    yield Register(
        "inputs", 0, "map_version", "u16", "Version of this map.",
        Stored("MAP_NUMBER", "MODBUS_MAP_VERSION"),
    )  # fmt: skip
    yield Register(
        "inputs", 1, "digest", "u32", "Digest of the specification.",
        Stored("MAP_NUMBER", "SPEC_DIGEST"),
    )  # fmt: skip
    yield _byte(3, "fault", "Code of the latched fault, 0 for none.", "fault.code")
    yield _celsius(
        4, "fault_temperature", "Temperature of the loop that tripped.",
        Stored("MAP_TENTHS", "&fault.temperature_c"),
    )  # fmt: skip
    yield _seconds(5, "fault_time", "When it tripped, in time since the reset.", "fault.time_s")
    yield _seconds(7, "uptime", "Time since the reset.", "seen.uptime_s")
    yield _byte(
        9, "acknowledgements", "Faults that were acknowledged since the reset; wraps at 256.",
        "fault.acknowledgements",
    )  # fmt: skip
    for address, (name, meaning) in enumerate(_COUNTERS.items(), start=10):
        stored = Stored("MAP_WORD", f"&modbus_counters.{name}")
        yield Register("inputs", address, name, "u16", f"{meaning}; wraps.", stored)


def _warnings(controller: Controller) -> Iterable[Register]:
    """Registers of the monitors, behind those that every controller has."""
    if controller.monitors:
        yield _byte(
            FIRST_MONITOR, "warnings", "Bits of the monitors that warn: 1 the first, 2 the second.",
            "seen.warnings",
        )  # fmt: skip
    for number, name in enumerate(controller.monitors):
        yield Register(
            "discretes", 1 + number, f"warning_{name}", "bit",
            f"The monitor {name} warns: too warm.", Stored("0xFF", f"&monitor_{name}.warns"),
        )  # fmt: skip
        yield _celsius(
            FIRST_MONITOR + 1 + number, f"monitor_{name}",
            f"Last good reading of the monitor {name}; {NO_TEMPERATURE} before the first.",
            Stored("MAP_WORD", f"&seen.monitor_{name}"),
        )  # fmt: skip


FIRST_MONITOR = 16
"""Address of the register `warnings`; the readings of the monitors follow."""
_COUNTERS = {
    "messages": "Frames on the line with a good CRC, to any slave",
    "errors": "Damaged frames: CRC, parity, framing, overrun, length",
    "exceptions": "Requests answered with an exception",
    "requests": "Requests to this slave, or to all",
    "unanswered": "Requests to all, which get no answer",
    "overruns": "Frames with a lost character",
}


def _coils_of_controller(controller: Controller) -> Iterable[Register]:
    coils = {"acknowledge": "A change from 0 to 1 acknowledges the latched fault."}
    if any(loop.tunable for loop in facts_of(controller).loops.values()):
        coils |= {
            "store": "A change from 0 to 1 stores all gains, so that they survive a loss of power.",
            "restore": "A change from 0 to 1 restores the gains of the specification.",
        }
    for address, (name, meaning) in enumerate(coils.items()):
        stored = Stored(f"0x{1 << address:02x}", "&coils")
        yield Register("coils", address, name, "bit", meaning, stored, "read, write")


def _loop(controller: Controller, name: str, block: int) -> Iterable[Register]:
    yield from _coils(controller, name, block)
    yield from _discretes(name, block)
    yield from _holdings(controller, name, block)
    yield from _inputs(controller, name, block)


def _coils(controller: Controller, name: str, block: int) -> Iterable[Register]:
    facts, mode = facts_of(controller, name), f"&seen.{name}_mode"
    enabled = Stored("0xFF", f"&seen.{name}_enabled")
    coils = [("enabled", "1 switches the loop on, 0 off.", enabled)]
    if facts.tunable:
        manual = "1 heats with `manual_duty`, 0 returns to automatic mode."
        coils.append(("manual", manual, Stored("0x02", mode)))
    if facts.autotune:
        tune = "1 starts a tuning at the setpoint, 0 ends it."
        coils.append(("tune", tune, Stored("0x04", mode)))
    for address, (what, meaning, stored) in enumerate(coils, start=block):
        yield Register(
            "coils", address, f"{name}.{what}", "bit", meaning, stored, access="read, write"
        )


_BITS = {
    "work": ("0x01", "The loop is on, and no fault is latched."),
    "heat": ("0x02", "The duty of its heater is above 0."),
    "cool": ("0x04", "Its cooler is commanded on."),
    "warm": ("0x08", "The loop works, and is near its setpoint."),
    "valid": ("0x20", "The last reading of its temperature was good."),
}


def _discretes(name: str, block: int) -> Iterable[Register]:
    for offset, (what, (mask, meaning)) in enumerate(_BITS.items()):
        yield Register(
            "discretes", block + offset, f"{name}.{what}", "bit", meaning,
            Stored(mask, f"&seen.{name}_state"),
        )  # fmt: skip


def _holdings(controller: Controller, name: str, block: int) -> Iterable[Register]:
    setpoint = controller.loops[name].setpoint
    yield Register(
        "holdings", block, f"{name}.setpoint", "i16", "Setpoint; does not switch the loop on.",
        Stored("MAP_TENTHS", f"&settings.{name}_setpoint_c"), "read, write", 0.1, "°C",
        setpoint.minimum_c, setpoint.maximum_c,
    )  # fmt: skip
    if not facts_of(controller, name).tunable:
        return
    yield Register(
        "holdings", block + 1, f"{name}.manual_duty", "u16", "Duty while the coil `manual` is on.",
        Stored("MAP_TENTHS", f"&seen.{name}_manual_percent"), "read, write", 0.1, "%", 0.0, 100.0,
    )  # fmt: skip
    for number, (gain, unit) in enumerate({"kp": "%/K", "ki": "%/(K·s)", "kd": "%·s/K"}.items()):
        yield Register(
            "holdings", block + 2 + 2 * number, f"{name}.{gain}", "f32",
            "Gain; both words in one request.", Stored("MAP_WORD", f"&settings.{name}_{gain}"),
            "read, write", 1.0, unit, 0.0, LARGEST_GAIN,
        )  # fmt: skip


def _inputs(controller: Controller, name: str, block: int) -> Iterable[Register]:
    facts = facts_of(controller, name)
    state = f"loop_{name}"
    yield _celsius(
        block, f"{name}.temperature",
        f"Last good reading; {NO_TEMPERATURE} before the first.",
        Stored("MAP_WORD", f"&seen.{name}_temperature"),
    )  # fmt: skip
    yield Register(
        "inputs", block + 1, f"{name}.duty", "u16", "Duty of the heater, from the algorithm.",
        Stored("MAP_TENTHS", f"&{state}.duty_percent"), scale=0.1, unit="%",
    )  # fmt: skip
    yield _celsius(
        block + 2, f"{name}.setpoint_in_force", "Setpoint of the last control step.",
        Stored("MAP_TENTHS", f"&{state}.setpoint_c"),
    )  # fmt: skip
    yield _byte(
        block + 3, f"{name}.state",
        "Bits: 1 work, 2 heat, 4 cool, 8 warm, 16 fault latched, 32 last reading good.",
        f"seen.{name}_state",
    )  # fmt: skip
    yield _byte(
        block + 4, f"{name}.reading", "Code of the rule that the last reading breaks, or 0.",
        f"{state}.reading_status",
    )  # fmt: skip
    if facts.current is not None:
        yield Register(
            "inputs", block + 5, f"{name}.current", "u16", "Mean current of the heater.",
            Stored("MAP_HUNDREDTHS", f"&current_{facts.heater}.amperes"), scale=0.01, unit="A",
        )  # fmt: skip
    elif facts.autotune or facts.response:
        yield Register(
            "inputs", block + 5, f"{name}.current", "u16", "No current is measured: always 0.",
            Stored("MAP_NUMBER", "0"), scale=0.01, unit="A",
        )  # fmt: skip
    if facts.autotune:
        yield _byte(
            block + 6, f"{name}.tuning",
            "State of the last tuning: 0 none, 1 runs, 2 done, 3 timed out, 4 stopped, "
            "5 too hot, 6 no usable gains.",
            f"autotune_{name}.result",
        )  # fmt: skip
    elif facts.response:
        yield Register(
            "inputs", block + 6, f"{name}.tuning", "u16", "No tuning here: always 0.",
            Stored("MAP_NUMBER", "0"),
        )  # fmt: skip
    if facts.response:
        yield from _response(name, block + 7)


def _response(name: str, first: int) -> Iterable[Register]:
    yield _byte(
        first, f"{name}.responses", "Setpoints that have settled since the reset; wraps at 256.",
        f"response_{name}.measured",
    )  # fmt: skip
    yield Register(
        "inputs", first + 1, f"{name}.settling_time", "f32",
        "Time until the last setpoint had settled.",
        Stored("MAP_WORD", f"&response_{name}.settling_s"), unit="s",
    )  # fmt: skip
    yield Register(
        "inputs", first + 3, f"{name}.overshoot", "i16", "Overshoot of the last settled setpoint.",
        Stored("MAP_TENTHS", f"&response_{name}.overshoot_k"), scale=0.1, unit="K",
    )  # fmt: skip
