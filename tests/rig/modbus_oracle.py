"""What a slave has to answer, and to do, to any bytes: written from docs/modbus.md alone."""

import math
import struct
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

from heatwright.sim.interfaces.modbus_rtu.frames import EXCEPTION, LONGEST, SHORTEST, crc, framed
from heatwright.sim.interfaces.modbus_rtu.registers import TENTH, Register, registers
from heatwright.spec import Controller, digest, facts_of

LOCKED_OUT = 3  # trips: the language's default
BAD_FUNCTION, BAD_ADDRESS, BAD_VALUE = 1, 2, 3
WRITES = (5, 6, 15, 16, 22)
TABLES = {1: "coil", 2: "discrete_input", 3: "holding_register", 4: "input_register"}
GAINS = ("kp", "ki", "kd")
STATES = ("work", "heat", "cool", "warm")
MODES = ("automatic", "manual", "tune")
COUNTERS = ("messages", "errors", "exceptions", "requests", "unanswered", "overruns")
FAULTY, GOOD = 16, 32
UNKNOWN_C = -32768
CYCLES = 5  # cycles of a tuning, in these specs


class Refused(Exception):
    """An exception of the protocol: its code."""


def check(condition: bool, code: int = BAD_VALUE) -> None:
    if not condition:
        raise Refused(code)


def single(value: float) -> float:
    return float(struct.unpack("<f", struct.pack("<f", value))[0])


def scaled(value: float, per_unit: int) -> int:
    """To nearest, halves away from zero, held to 16 bits; what single precision makes of it."""
    steps = single(single(value) * per_unit)
    steps = single(steps + (-0.5 if steps < 0 else 0.5))
    return int(max(-32767.0, min(32767.0, steps)))


@dataclass
class Control:
    """What a master sets of a loop."""

    setpoint: float
    enabled: bool
    gains: dict[str, float]
    released: bool = False
    mode: str = "automatic"
    manual_duty: float = 0.0


class Oracle:
    """One slave.

    world -- what the machine itself decides, by the names of registers; of a loop also
    `has_reading`, `missing`, and `states`, the bits of STATES. changes -- how many requests have
    changed something. calls -- how often something was stored and restored, and for how
    many cycles tuned.
    """

    def __init__(self, controller: Controller) -> None:
        modbus = facts_of(controller).modbus
        assert modbus is not None
        self.address = modbus.address
        self.fault = self.acknowledged = self.changes = 0
        self.counters = dict.fromkeys(COUNTERS, 0)
        self.calls: Counter[str] = Counter()
        self.world: dict[str, float] = {}
        self._controller = controller
        self.digest = digest(controller)
        self._tables: dict[str, dict[int, tuple[Register, int]]] = defaultdict(dict)
        for register in registers(controller).values():
            for word in range(register.words):
                self._tables[register.table][register.address + word] = register, word
        self.loops = {
            name: Control(single(loop.setpoint.initial_c), loop.starts == "enabled",
                          self._default_gains(name))
            for name, loop in controller.loops.items()
        }  # fmt: skip
        commands = [coil.name for coil, _ in self._tables["coil"].values() if "." not in coil.name]
        self._orders = dict.fromkeys(commands, False)
        """The controller's coils, as they were last written."""
        self._rested: set[str] = set()  # those that were last written 0; none at the reset

    def _default_gains(self, name: str) -> dict[str, float]:
        if not facts_of(self._controller, name).tunable:
            return {}
        algorithm = self._controller.loops[name].algorithm
        return {gain: single(getattr(algorithm, gain)) for gain in GAINS}

    def hear(self, data: bytes, *, whole: bool = True) -> bytes:
        """Return the answer to a frame with silence behind it; nothing for silence.

        whole -- no character was damaged.
        """
        if not data:
            return b""
        if not whole or not SHORTEST <= len(data) <= LONGEST or crc(data[:-2]) != data[-2:]:
            self.counters["errors"] += 1
            return b""
        self.counters["messages"] += 1
        address, pdu = data[0], data[1:-2]
        if address not in (0, self.address):
            return b""
        self.counters["requests"] += 1
        before = repr(self.loops)
        answer = self._answered(address, pdu)
        self.changes += before != repr(self.loops)
        return answer

    def _answered(self, address: int, pdu: bytes) -> bytes:
        if address == 0:
            self.counters["unanswered"] += 1
            if pdu[0] in WRITES:
                with suppress(Refused):
                    self._serve(pdu[0], pdu[1:])
            return b""
        try:
            return framed(address, bytes([pdu[0]]) + self._serve(pdu[0], pdu[1:]))
        except Refused as refused:
            self.counters["exceptions"] += 1
            return framed(address, bytes([pdu[0] | EXCEPTION, refused.args[0]]))

    def _serve(self, function: int, data: bytes) -> bytes:
        if function in TABLES:
            return self._read(function, data)
        served: dict[int, Callable[[bytes], bytes]] = {
            5: self._write_coil, 6: self._write_register, 15: self._write_coils,
            16: self._write_registers, 17: self._identity, 22: self._mask,
            23: self._read_and_write, 43: self._identify,
        }  # fmt: skip
        check(function in served, BAD_FUNCTION)
        return served[function](data)

    def _span(self, table: str, first: int, count: int) -> list[tuple[Register, int]]:
        found = self._tables[table]
        check(all(first + n in found for n in range(count)), BAD_ADDRESS)
        return [found[first + n] for n in range(count)]

    def _word(self, register: Register, word: int) -> int:
        loop, _, what = register.name.rpartition(".")
        value = self._of_loop(loop, what) if loop else self._of_controller(what)
        if register.kind == "f32":
            return int(struct.unpack(">2H", struct.pack(">f", value))[word])
        if register.words == 2:
            return int(value) >> (16, 0)[word] & 0xFFFF
        if register.scale != 1 and value != UNKNOWN_C:
            value = scaled(value, round(1 / register.scale))
        return int(value) & 0xFFFF

    def _of_controller(self, what: str) -> float:
        known = {
            **self._orders, **self.counters, "fault": self.fault, "map_version": 1,
            "fault_latched": self.fault != 0, "digest": int(self.digest, 16),
            "acknowledgements": self.acknowledged & 0xFF,
        }  # fmt: skip
        return known[what] if what in known else self.world.get(what, 0)

    def _of_loop(self, loop: str, what: str) -> float:
        control = self.loops[loop]
        known = self.world.get(f"{loop}.has_reading", 0)
        state = int(self.world.get(f"{loop}.states", 0)) | FAULTY * (self.fault != 0)
        state |= GOOD * bool(known and not self.world.get(f"{loop}.missing", 0))
        told = {
            **control.gains, "enabled": control.enabled, "state": state, "valid": state & GOOD != 0,
            "setpoint": control.setpoint, "manual_duty": control.manual_duty,
            **{name: control.mode == name for name in MODES[1:]},
            **{name: state >> bit & 1 for bit, name in enumerate(STATES)},
        }  # fmt: skip
        if what == "temperature" and not known:
            return UNKNOWN_C
        return told[what] if what in told else self.world.get(f"{loop}.{what}", 0)

    @staticmethod
    def _asked(data: bytes, most: int) -> tuple[int, int]:
        check(len(data) == 4)
        first, count = struct.unpack(">HH", data)
        check(1 <= count <= most)
        return first, count

    def _counted(self, data: bytes, most: int, bits: int) -> tuple[int, int, bytes]:
        """Read the head of a request that writes, and how many bytes follow."""
        check(len(data) >= 5)
        first, count = self._asked(data[:4], most)
        check(data[4] == (count * bits + 7) // 8 == len(data) - 5)
        return first, count, data[5:]

    def _read(self, function: int, data: bytes) -> bytes:
        bits = function in (1, 2)
        first, count = self._asked(data, 2000 if bits else 125)
        words = [self._word(*each) for each in self._span(TABLES[function], first, count)]
        if not bits:
            return listed(words)
        packed = sum(bool(word) << n for n, word in enumerate(words))
        size = (count + 7) // 8
        return bytes([size]) + packed.to_bytes(size, "little")

    def _write(self, first: int, words: Sequence[int]) -> None:
        span = self._span("holding_register", first, len(words))
        name = span[0][0].name.rpartition(".")[0]
        raw: dict[Register, list[int]] = defaultdict(list)
        for (register, _), word in zip(span, words, strict=True):
            raw[register].append(word)
        for register, parts in raw.items():
            check(len(parts) == register.words)
        control = self.loops[name]
        wishes = {each.name.rpartition(".")[2]: each.value(parts) for each, parts in raw.items()}
        for what, value in wishes.items():
            check(self._may(name, what, value))
        for what, value in wishes.items():
            if what in GAINS:
                control.gains[what] = value
            else:
                setattr(control, what, single(round(value / TENTH) / 10))

    def _may(self, name: str, what: str, value: float) -> bool:
        control, loop = self.loops[name], self._controller.loops[name]
        if what == "setpoint":
            tenths = round(value / TENTH)
            inside = loop.setpoint.minimum_c <= tenths / 10 <= loop.setpoint.maximum_c
            return inside and (control.mode != "tune" or single(tenths / 10) == control.setpoint)
        if what == "manual_duty":
            return round(value / TENTH) <= 1000
        return math.isfinite(value) and 0 <= value <= 1e6

    def _write_register(self, data: bytes) -> bytes:
        check(len(data) == 4)
        address, word = struct.unpack(">HH", data)
        self._write(address, [word])
        return data

    def _write_registers(self, data: bytes) -> bytes:
        first, count, values = self._counted(data, 123, 16)
        self._write(first, struct.unpack(f">{count}H", values))
        return data[:4]

    def _mask(self, data: bytes) -> bytes:
        check(len(data) == 6)
        address, keep, add = struct.unpack(">HHH", data)
        old = self._word(*self._span("holding_register", address, 1)[0])
        self._write(address, [old & keep | add & ~keep & 0xFFFF])
        return data

    def _read_and_write(self, data: bytes) -> bytes:
        check(len(data) >= 9)
        first, count = self._asked(data[:4], 125)
        second, more, values = self._counted(data[4:], 121, 16)
        span = self._span("holding_register", first, count)
        self._write(second, struct.unpack(f">{more}H", values))
        return listed([self._word(*each) for each in span])

    def _write_coil(self, data: bytes) -> bytes:
        check(len(data) == 4)
        address, value = struct.unpack(">HH", data)
        check(value in (0, 0xFF00))
        self._switch(address, [bool(value)])
        return data

    def _write_coils(self, data: bytes) -> bytes:
        first, count, values = self._counted(data, 1968, 1)
        bits = int.from_bytes(values, "little")
        self._switch(first, [bool(bits >> n & 1) for n in range(count)])
        return data[:4]

    def _switch(self, first: int, states: list[bool]) -> None:
        span = self._span("coil", first, len(states))
        names = [register.name.rpartition(".")[2] for register, _ in span]
        wanted = dict(zip(names, states, strict=True))
        if name := span[0][0].name.rpartition(".")[0]:
            self._switch_loop(self.loops[name], wanted)
        else:
            self._command(wanted)

    def _command(self, wanted: Mapping[str, bool]) -> None:
        """A command acts when it changes to 1 from a 0 that was written."""
        risen = {name for name, on in wanted.items() if on and name in self._rested}
        check("acknowledge" not in risen or self.world.get("trips", 0) < LOCKED_OUT)
        self._orders.update(wanted)
        self._rested |= wanted.keys()
        self._rested -= {name for name, on in wanted.items() if on}
        if "acknowledge" in risen and self.fault:
            self.fault = 0
            self.acknowledged += 1
            for control in self.loops.values():
                control.enabled, control.mode = False, "automatic"
        self.calls.update(risen)
        if "restore" in risen:
            for loop, control in self.loops.items():
                control.gains = self._default_gains(loop)

    def _switch_loop(self, control: Control, wanted: Mapping[str, bool]) -> None:
        manual, tune = wanted.get("manual"), wanted.get("tune")
        if wanted.get("enabled"):
            check(not self.fault and (control.enabled or control.released))
        check(not (manual and tune))
        if manual or tune:
            check(not self.fault and wanted.get("enabled", control.enabled))
        if "enabled" in wanted:
            control.enabled = wanted["enabled"]
            if not control.enabled:
                control.released, control.mode = True, "automatic"
        if manual:
            control.mode = "manual"
        elif "manual" in wanted and control.mode == "manual":
            control.mode = "automatic"
        if tune:
            if control.mode != "tune":
                self.calls["tune"] += CYCLES
            control.mode = "tune"
        elif "tune" in wanted and control.mode == "tune":
            control.mode, control.enabled, control.released = "automatic", False, False

    def _identity(self, data: bytes) -> bytes:
        check(not data)
        works = any(int(self.world.get(f"{loop}.states", 0)) & 1 for loop in self.loops)
        said = bytes([0x48, 0xFF * works]) + self._controller.identity.name.encode()
        return bytes([len(said)]) + said

    def _identify(self, data: bytes) -> bytes:
        check(len(data) >= 1 and data[0] == 14, BAD_FUNCTION)
        check(len(data) == 3 and 1 <= data[1] <= 4)
        code, first = data[1:]
        identity = self._controller.identity
        title = identity.title or identity.name
        shown = "".join(each if " " <= each <= "~" else "?" for each in title)
        texts = {0: "heatwright", 1: identity.name, 2: f"1 {self.digest}", 4: shown}
        objects = {number: text.encode("ascii") for number, text in texts.items()}
        if code == 4:
            check(first in objects, BAD_ADDRESS)
            named = {first: objects[first]}
        else:
            last = 2 if code == 1 else 255
            named = {each: text for each, text in objects.items() if each <= last}
            if first in named:
                named = {each: text for each, text in named.items() if each >= first}
        told = b"".join(bytes([each, len(text)]) + text for each, text in named.items())
        return bytes([14, code, 0x82, 0, 0, len(named)]) + told


def listed(words: Sequence[int]) -> bytes:
    """Count of bytes, and words."""
    return struct.pack(f">B{len(words)}H", 2 * len(words), *words)
