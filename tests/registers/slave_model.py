"""What the slave of slave_spec has to answer, written from docs/modbus.md and the standard."""

import struct
from collections.abc import Callable
from contextlib import suppress

from slave_spec import ADDRESS
from slave_state import Refusal, State, span, words

EXCEPTION = 0x80


def crc16(data: bytes) -> bytes:
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ 0xA001 if crc & 1 else crc >> 1
    return struct.pack("<H", crc)


def framed(address: int, pdu: bytes) -> bytes:
    frame = bytes([address]) + pdu
    return frame + crc16(frame)


class Slave(State):
    """Frames in, answers out."""

    def frame(self, frame: bytes) -> bytes:
        """Answer a frame that came with silence behind it."""
        if not frame:
            return b""
        if not 4 <= len(frame) <= 256 or crc16(frame[:-2]) != frame[-2:]:
            self.counters["errors"] += 1
            return b""
        self.counters["messages"] += 1
        address, pdu = frame[0], frame[1:-2]
        if address not in {0, ADDRESS}:
            return b""
        self.counters["requests"] += 1
        if address == 0:
            self.counters["unanswered"] += 1
            if pdu[0] in {5, 6, 15, 16, 22}:
                with suppress(Refusal):
                    self._do(pdu[0], pdu[1:])
            return b""
        try:
            return framed(address, bytes([pdu[0]]) + self._do(pdu[0], pdu[1:]))
        except Refusal as refusal:
            self.counters["exceptions"] += 1
            return framed(address, bytes([pdu[0] | EXCEPTION, refusal.args[0]]))

    def _do(self, function: int, data: bytes) -> bytes:
        does: dict[int, Callable[[bytes], bytes]] = {
            1: lambda data: self._read_bits(self.coils(), data),
            2: lambda data: self._read_bits(self.discretes(), data),
            3: lambda data: self._read_words(self.holdings(), data),
            4: lambda data: self._read_words(self.inputs(), data),
            5: self._write_coil,
            6: self._write_register,
            15: self._write_coils,
            16: self._write_registers,
            17: self._report,
            22: self._mask,
            23: self._read_and_write,
            43: self._identify,
        }
        if function not in does:
            raise Refusal(1)
        return does[function](data)

    def _read_words(self, table: dict[int, int], data: bytes) -> bytes:
        first, count = self._asked(data, 125)
        return words(span(table, first, count))

    def _write_coil(self, data: bytes) -> bytes:
        if len(data) != 4 or data[2:] not in {b"\0\0", b"\xff\0"}:
            raise Refusal(3)
        first = struct.unpack(">H", data[:2])[0]
        span(self.coils(), first, 1)
        self.switch(first, [data[2] == 0xFF])
        return data

    def _write_coils(self, data: bytes) -> bytes:
        first, count = self._counted(data, 1968, lambda count: (count + 7) // 8)
        span(self.coils(), first, count)
        self.switch(first, [bool(data[5 + i // 8] >> i % 8 & 1) for i in range(count)])
        return data[:4]

    def _write_register(self, data: bytes) -> bytes:
        if len(data) != 4:
            raise Refusal(3)
        self.write(struct.unpack(">H", data[:2])[0], data[2:])
        return data

    def _write_registers(self, data: bytes) -> bytes:
        first, _ = self._counted(data, 123, lambda count: 2 * count)
        self.write(first, data[5:])
        return data[:4]

    def _mask(self, data: bytes) -> bytes:
        if len(data) != 6:
            raise Refusal(3)
        first, keep, add = struct.unpack(">HHH", data)
        (old,) = span(self.holdings(), first, 1)
        self.write(first, struct.pack(">H", old & keep | add & ~keep & 0xFFFF))
        return data

    def _report(self, data: bytes) -> bytes:
        if data:
            raise Refusal(3)
        working = int(self.world.get("S", 0)) | int(self.world.get("B", 0))
        told = bytes([0x48, 0xFF if working & 1 else 0]) + self.name.encode()
        return bytes([len(told)]) + told

    def _asked(self, data: bytes, most: int) -> tuple[int, int]:
        if len(data) != 4:
            raise Refusal(3)
        first, count = struct.unpack(">HH", data)
        if not 1 <= count <= most:
            raise Refusal(3)
        return first, count

    def _counted(self, data: bytes, most: int, size: Callable[[int], int]) -> tuple[int, int]:
        if len(data) < 5:
            raise Refusal(3)
        first, count = self._asked(data[:4], most)
        if data[4] != size(count) or len(data) != 5 + data[4]:
            raise Refusal(3)
        return first, count

    def _read_bits(self, table: dict[int, int], data: bytes) -> bytes:
        first, count = self._asked(data, 2000)
        bits = span(table, first, count)
        size = (count + 7) // 8
        number = sum(bool(bit) << i for i, bit in enumerate(bits))
        return bytes([size]) + number.to_bytes(size, "little")

    def _read_and_write(self, data: bytes) -> bytes:
        if len(data) < 9:
            raise Refusal(3)
        first, count, to, writes, size = struct.unpack(">HHHHB", data[:9])
        if not (1 <= count <= 125 and 1 <= writes <= 121):
            raise Refusal(3)
        if size != 2 * writes or len(data) != 9 + size:
            raise Refusal(3)
        span(self.holdings(), first, count)
        self.write(to, data[9:])
        return words(span(self.holdings(), first, count))

    def _identify(self, data: bytes) -> bytes:
        if not data or data[0] != 14:
            raise Refusal(1)
        if len(data) != 3 or not 1 <= data[1] <= 4:
            raise Refusal(3)
        objects = {
            0: "heatwright", 1: self.name, 2: f"1 {self.digest:08x}",
            4: "".join(each if " " <= each <= "~" else "?" for each in self.title),
        }  # fmt: skip
        if data[1] == 4:
            if data[2] not in objects:
                raise Refusal(2)
            told = {data[2]: objects[data[2]]}
        else:
            most = 2 if data[1] == 1 else 4
            inside = {each: text for each, text in objects.items() if each <= most}
            start = data[2] if data[2] in inside else 0
            told = {each: text for each, text in inside.items() if each >= start}
        shown = b"".join(
            bytes([each, len(text)]) + text.encode("ascii") for each, text in told.items()
        )
        return bytes([14, data[1], 0x82, 0, 0, len(told)]) + shown
