"""What a slave has to answer, and to do, to any bytes: written from docs/modbus.md alone."""

import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass

from heatwright.sim.interfaces.modbus_frames import EXCEPTION, LONGEST, SHORTEST, crc, framed
from heatwright.sim.interfaces.registers import Register, registers
from heatwright.spec import Controller, digest, modbus_of
from heatwright.spec.commands import tunable

BAD_FUNCTION, BAD_ADDRESS, BAD_VALUE = 1, 2, 3
WRITES = (5, 6, 15, 16, 22)
TABLES = {1: "coil", 2: "discrete_input", 3: "holding_register", 4: "input_register"}
GAINS = ("kp", "ki", "kd")
MOST_GAIN = 1e6
MAP_VERSION = 1


class Refused(Exception):
    """An exception of the protocol."""

    def __init__(self, code: int) -> None:
        super().__init__(code)
        self.code = code


def check(condition: bool, code: int) -> None:
    if not condition:
        raise Refused(code)


@dataclass
class Control:
    """What a master sets of a loop."""

    setpoint: int
    enabled: bool
    gains: dict[str, bytes]
    released: bool = False
    mode: str = "automatic"
    manual_duty: int = 0


class Oracle:
    """One slave without faults; what the machine itself decides it does not know.

    changes -- how many requests have changed something.
    """

    def __init__(self, controller: Controller) -> None:
        modbus = modbus_of(controller)
        assert modbus is not None
        self.address = modbus.address
        self.changes = 0
        self.commands: dict[str, bool] = {}
        self._controller = controller
        self._registers = list(registers(controller).values())
        self.loops = {name: self._control(name) for name in controller.loops}

    def _control(self, name: str) -> Control:
        loop = self._controller.loops[name]
        gains = self._default_gains(name)
        return Control(round(loop.setpoint.initial_c * 10), loop.starts != "disabled", gains)

    def _default_gains(self, name: str) -> dict[str, bytes]:
        if not tunable(self._controller, name):
            return {}
        algorithm = self._controller.loops[name].algorithm
        return {gain: struct.pack(">f", getattr(algorithm, gain)) for gain in GAINS}

    # -- frames --------------------------------------------------------------------------------

    def hear(self, data: bytes, *, whole: bool = True) -> bytes | None:
        """Return the answer to a frame; None for silence. whole -- no character was damaged."""
        if not whole or not SHORTEST <= len(data) <= LONGEST or crc(data[:-2]) != data[-2:]:
            return None
        address, pdu = data[0], data[1:-2]
        if address not in (0, self.address):
            return None
        if address == 0:
            if pdu[0] in WRITES:
                self._answer(pdu)
            return None
        return framed(address, self._answer(pdu))

    def _answer(self, pdu: bytes) -> bytes:
        try:
            return self._serve(pdu)
        except Refused as refused:
            return bytes([pdu[0] | EXCEPTION, refused.code])

    def _serve(self, pdu: bytes) -> bytes:
        function = pdu[0]
        if function in TABLES:
            return self._read(pdu)
        served = {
            5: self._write_coil,
            6: self._write_register,
            15: self._write_coils,
            16: self._write_registers,
            17: self._identity,
            22: self._mask,
            23: self._read_and_write,
            43: self._identify,
        }
        check(function in served, BAD_FUNCTION)
        return served[function](pdu)

    # -- tables --------------------------------------------------------------------------------

    def _table(self, table: str) -> dict[int, tuple[Register, int]]:
        return {
            register.address + word: (register, word)
            for register in self._registers
            if register.table == table
            for word in range(register.words)
        }

    def _span(self, table: str, first: int, count: int) -> list[tuple[Register, int]]:
        found = self._table(table)
        check(all(first + n in found for n in range(count)), BAD_ADDRESS)
        return [found[first + n] for n in range(count)]

    def _word(self, register: Register, word: int) -> int:
        """A word that a master can write; of others 0."""
        loop, _, what = register.name.rpartition(".")
        if not loop:
            return int(self.commands.get(what, False))
        control = self.loops[loop]
        if what == "setpoint":
            return control.setpoint & 0xFFFF
        if what == "manual_duty":
            return control.manual_duty
        if what in GAINS:
            return struct.unpack(">2H", control.gains[what])[word]
        return {
            "enabled": int(control.enabled),
            "manual": int(control.mode == "manual"),
            "tune": int(control.mode == "tuning"),
        }.get(what, 0)

    def _read(self, pdu: bytes) -> bytes:
        check(len(pdu) == 5, BAD_VALUE)
        function, first, count = struct.unpack(">BHH", pdu)
        bits = function in (1, 2)
        check(1 <= count <= (2000 if bits else 125), BAD_VALUE)
        words = [self._word(*each) for each in self._span(TABLES[function], first, count)]
        if not bits:
            return struct.pack(f">BB{count}H", function, 2 * count, *words)
        packed = sum(bool(word) << n for n, word in enumerate(words))
        size = (count + 7) // 8
        return bytes([function, size]) + packed.to_bytes(size, "little")

    # -- registers -----------------------------------------------------------------------------

    def _write(self, first: int, words: tuple[int, ...]) -> None:
        span = self._span("holding_register", first, len(words))
        name = span[0][0].name.rpartition(".")[0]
        raw: dict[str, dict[int, int]] = {}
        for (register, part), word in zip(span, words, strict=True):
            raw.setdefault(register.name.rpartition(".")[2], {})[part] = word
        for what, parts in raw.items():
            check(self._may(name, what, parts), BAD_VALUE)
        control = self.loops[name]
        before = (control.setpoint, control.manual_duty, dict(control.gains))
        for what, parts in raw.items():
            if what == "setpoint":
                control.setpoint = signed(parts[0])
            elif what == "manual_duty":
                control.manual_duty = parts[0]
            else:
                control.gains[what] = struct.pack(">2H", parts[0], parts[1])
        self.changes += before != (control.setpoint, control.manual_duty, control.gains)

    def _may(self, name: str, what: str, parts: Mapping[int, int]) -> bool:
        control, loop = self.loops[name], self._controller.loops[name]
        if what == "setpoint":
            tenths = signed(parts[0])
            inside = loop.setpoint.minimum_c <= tenths / 10 <= loop.setpoint.maximum_c
            return inside and (control.mode != "tuning" or tenths == control.setpoint)
        if what == "manual_duty":
            return 0 <= signed(parts[0]) <= 1000
        if len(parts) != 2:
            return False
        value = struct.unpack(">f", struct.pack(">2H", parts[0], parts[1]))[0]
        return math.isfinite(value) and 0 <= value <= MOST_GAIN

    def _write_register(self, pdu: bytes) -> bytes:
        check(len(pdu) == 5, BAD_VALUE)
        _, address, word = struct.unpack(">BHH", pdu)
        self._write(address, (word,))
        return pdu

    def _write_registers(self, pdu: bytes) -> bytes:
        check(len(pdu) >= 6, BAD_VALUE)
        _, first, count, size = struct.unpack(">BHHB", pdu[:6])
        check(1 <= count <= 123 and size == 2 * count and len(pdu) == 6 + size, BAD_VALUE)
        self._write(first, struct.unpack(f">{count}H", pdu[6:]))
        return pdu[:5]

    def _mask(self, pdu: bytes) -> bytes:
        check(len(pdu) == 7, BAD_VALUE)
        _, address, with_and, with_or = struct.unpack(">BHHH", pdu)
        old = self._word(*self._span("holding_register", address, 1)[0])
        self._write(address, (old & with_and | with_or & ~with_and & 0xFFFF,))
        return pdu

    def _read_and_write(self, pdu: bytes) -> bytes:
        check(len(pdu) >= 10, BAD_VALUE)
        first, count, second, more, size = struct.unpack(">HHHHB", pdu[1:10])
        check(1 <= count <= 125 and 1 <= more <= 121, BAD_VALUE)
        check(size == 2 * more and len(pdu) == 10 + size, BAD_VALUE)
        span = self._span("holding_register", first, count)
        self._write(second, struct.unpack(f">{more}H", pdu[10:]))
        words = [self._word(*each) for each in span]
        return struct.pack(f">BB{count}H", 23, 2 * count, *words)

    # -- coils ---------------------------------------------------------------------------------

    def _write_coil(self, pdu: bytes) -> bytes:
        check(len(pdu) == 5, BAD_VALUE)
        _, address, value = struct.unpack(">BHH", pdu)
        check(value in (0, 0xFF00), BAD_VALUE)
        self._switch(address, [bool(value)])
        return pdu

    def _write_coils(self, pdu: bytes) -> bytes:
        check(len(pdu) >= 6, BAD_VALUE)
        _, first, count, size = struct.unpack(">BHHB", pdu[:6])
        check(1 <= count <= 1968 and size == (count + 7) // 8 and len(pdu) == 6 + size, BAD_VALUE)
        bits = int.from_bytes(pdu[6:], "little")
        self._switch(first, [bool(bits >> n & 1) for n in range(count)])
        return pdu[:5]

    def _switch(self, first: int, states: list[bool]) -> None:
        span = self._span("coil", first, len(states))
        wanted = {
            register.name.rpartition(".")[2]: state
            for (register, _), state in zip(span, states, strict=True)
        }
        name = span[0][0].name.rpartition(".")[0]
        if not name:
            self._command(wanted)
            return
        control = self.loops[name]
        before = (control.enabled, control.mode)
        self._check_switches(control, wanted)
        self._do_switches(control, wanted)
        self.changes += before != (control.enabled, control.mode)

    def _command(self, wanted: Mapping[str, bool]) -> None:
        """A command acts when it changes to 1 from a 0 that was written."""
        if wanted.get("restore") and self.commands.get("restore") is False:
            for loop, control in self.loops.items():
                control.gains = self._default_gains(loop)
        self.commands.update(wanted)

    @staticmethod
    def _check_switches(control: Control, wanted: Mapping[str, bool]) -> None:
        manual, tune = wanted.get("manual"), wanted.get("tune")
        if wanted.get("enabled"):
            check(control.enabled or control.released, BAD_VALUE)
        check(not (manual and tune), BAD_VALUE)
        if manual or tune:
            check(wanted.get("enabled", control.enabled), BAD_VALUE)

    @staticmethod
    def _do_switches(control: Control, wanted: Mapping[str, bool]) -> None:
        if "enabled" in wanted:
            control.enabled = wanted["enabled"]
            if not control.enabled:
                control.released, control.mode = True, "automatic"
        if wanted.get("manual"):
            control.mode = "manual"
        elif "manual" in wanted and control.mode == "manual":
            control.mode = "automatic"
        if wanted.get("tune"):
            control.mode = "tuning"
        elif "tune" in wanted and control.mode == "tuning":
            control.mode, control.enabled, control.released = "automatic", False, False

    # -- who it is -----------------------------------------------------------------------------

    def _identity(self, pdu: bytes) -> bytes:
        check(len(pdu) == 1, BAD_VALUE)
        runs = any(control.enabled for control in self.loops.values())
        said = bytes([0x48, 0xFF if runs else 0]) + self._controller.identity.name.encode()
        return bytes([17, len(said)]) + said

    def _objects(self) -> dict[int, bytes]:
        identity = self._controller.identity
        texts = {
            0: "heatwright",
            1: identity.name,
            2: f"{MAP_VERSION} {digest(self._controller)}",
            4: identity.title or identity.name,
        }
        return {number: text.encode() for number, text in texts.items()}

    def _identify(self, pdu: bytes) -> bytes:
        check(len(pdu) >= 2 and pdu[1] == 14, BAD_FUNCTION)
        check(len(pdu) == 4 and 1 <= pdu[2] <= 4, BAD_VALUE)
        code, first = pdu[2], pdu[3]
        objects = self._objects()
        if code == 4:
            check(first in objects, BAD_ADDRESS)
            named = {first: objects[first]}
        else:
            last = 2 if code == 1 else 255
            named = {each: text for each, text in objects.items() if each <= last}
            if first in named:
                named = {each: text for each, text in named.items() if each >= first}
        listed = b"".join(bytes([each, len(text)]) + text for each, text in named.items())
        return bytes([43, 14, code, 0x82, 0, 0, len(named)]) + listed


def signed(word: int) -> int:
    return word - 0x10000 if word & 0x8000 else word
