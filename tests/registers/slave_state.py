"""What the slave of slave_spec holds, and its map, written from docs/modbus.md."""

import math
import struct
from dataclasses import dataclass, field


class Refusal(Exception):
    """An exception's code."""


def single(value: float) -> float:
    """Round to single precision."""
    return float(struct.unpack("<f", struct.pack("<f", value))[0])


def tenths(value: float, per_unit: int = 10) -> int:
    """To nearest, halves away from zero, held to 16 bits; what single precision makes of it."""
    steps = single(single(value) * per_unit)
    steps = single(steps + (-0.5 if steps < 0 else 0.5))
    return int(max(-32767.0, min(32767.0, steps)))


@dataclass
class Loop:
    setpoint: float
    minimum: float
    maximum: float
    enabled: bool = True
    released: bool = False
    mode: int = 0
    percent: float = 0.0
    gains: list[float] = field(default_factory=list)


@dataclass
class State:
    """The controller, its loops, the world about it, and the counters of the line."""

    digest: int
    name: str
    title: str
    air: Loop = field(
        default_factory=lambda: Loop(20.0, -5.0, 250.0, gains=[8.0, single(0.05), 30.0])
    )
    bed: Loop = field(default_factory=lambda: Loop(20.0, 10.0, 70.5))
    fault: int = 0
    acknowledged: int = 0
    orders: dict[int, int] = field(default_factory=lambda: dict.fromkeys(range(3), 0))
    """The controller's coils, as they were last written."""
    rested: set[int] = field(default_factory=set)
    """Those that were last written 0; none at the reset."""
    kept: int = 0
    defaulted: int = 0
    cycles: int = 0
    counters: dict[str, int] = field(
        default_factory=lambda: dict.fromkeys(
            ("messages", "errors", "exceptions", "requests", "unanswered", "overruns"), 0
        )
    )
    world: dict[str, float] = field(default_factory=dict)

    def coils(self) -> dict[int, int]:
        air = self.air
        return {
            **self.orders, 100: air.enabled, 101: air.mode == 1, 102: air.mode == 2,
            200: self.bed.enabled,
        }  # fmt: skip

    def states(self) -> tuple[int, int]:
        latched = 16 if self.fault else 0
        good = self.world.get("h", 0) and not self.world.get("m", 0)
        air = int(self.world.get("S", 0)) | latched | (32 if good else 0)
        return air, int(self.world.get("B", 0)) | latched

    def discretes(self) -> dict[int, int]:
        table = {0: int(self.fault != 0)}
        for block, state in zip((100, 200), self.states(), strict=True):
            for offset, bit in enumerate((1, 2, 4, 8, 32)):
                table[block + offset] = state & bit
        return table

    def holdings(self) -> dict[int, int]:
        gains = struct.unpack(">6H", struct.pack(">3f", *self.air.gains))
        return {
            100: tenths(self.air.setpoint) & 0xFFFF,
            101: tenths(self.air.percent),
            **{102 + i: word for i, word in enumerate(gains)},
            200: tenths(self.bed.setpoint) & 0xFFFF,
        }

    def inputs(self) -> dict[int, int]:
        world, (air, bed) = self.world, self.states()
        known = bool(world.get("h", 0))
        table = {0: 1, **pair(1, self.digest), 3: self.fault, 4: tenths(world.get("F", 0))}
        table |= {**pair(5, int(world.get("T", 0))), **pair(7, int(world.get("n", 0)))}
        table[9] = self.acknowledged & 0xFF
        table |= {10 + i: count & 0xFFFF for i, count in enumerate(self.counters.values())}
        table |= {
            100: tenths(world.get("t", 0)) if known else -32768,
            101: tenths(world.get("d", 0)), 102: tenths(world.get("c", 0)), 103: air,
            104: int(world.get("r", 0)), 105: 0, 106: int(world.get("a", 0)),
            200: -32768, 201: 0, 202: 0, 203: bed, 204: 0,
            205: tenths(world.get("A", 0), 100),
        }  # fmt: skip
        return {address: word & 0xFFFF for address, word in table.items()}

    def write(self, first: int, data: bytes) -> None:
        """Write words that are there, all or none."""
        count = len(data) // 2
        span(self.holdings(), first, count)
        if first >= 200:
            self._set(self.bed, struct.unpack(">h", data)[0] / 10)
            return
        old = words([self.holdings()[100 + i] for i in range(8)])[1:]
        at = 2 * (first - 100)
        new = old[:at] + data + old[at + len(data) :]
        offsets = range(first - 100, first - 100 + count)
        if any((2 + 2 * i in offsets) != (3 + 2 * i in offsets) for i in range(3)):
            raise Refusal(3)
        setpoint, percent, *gains = struct.unpack(">hh3f", new)
        if not 0 <= percent <= 1000:
            raise Refusal(3)
        if not all(math.isfinite(gain) and 0 <= gain <= 1e6 for gain in gains):
            raise Refusal(3)
        if 0 in offsets:
            self._set(self.air, setpoint / 10)
        if 1 in offsets:
            self.air.percent = single(percent / 10)
        self.air.gains = list(gains)

    def _set(self, loop: Loop, value: float) -> None:
        if loop.mode == 2 and single(value) != loop.setpoint:
            raise Refusal(3)
        if not loop.minimum <= value <= loop.maximum:
            raise Refusal(3)
        loop.setpoint = single(value)

    def switch(self, first: int, bits: list[bool]) -> None:
        """Switch coils that are there, all or none."""
        named = {first % 100 + i: bit for i, bit in enumerate(bits)}
        if first < 100:
            self._switch_controller(named)
        else:
            loop = self.air if first < 200 else self.bed
            _look(loop, named, faulty=self.fault != 0)
            if _switch(loop, named):
                self.cycles = 5

    def _switch_controller(self, named: dict[int, bool]) -> None:
        risen = {coil for coil, on in named.items() if on} & self.rested
        self.orders |= named
        self.rested = (self.rested | named.keys()) - {coil for coil, on in named.items() if on}
        if 0 in risen and self.fault:
            self.fault = 0
            self.acknowledged += 1
            self.air.enabled = self.bed.enabled = False
            self.air.mode = 0
        self.kept += 1 in risen
        self.defaulted += 2 in risen


def _look(loop: Loop, named: dict[int, bool], *, faulty: bool) -> None:
    """Refuse what cannot be now."""
    enabled, manual, tune = (named.get(offset) for offset in range(3))
    if enabled and (faulty or not (loop.released or loop.enabled)):
        raise Refusal(3)
    works = loop.enabled if enabled is None else enabled
    if (manual or tune) and (not works or faulty or (manual and tune)):
        raise Refusal(3)


def _switch(loop: Loop, named: dict[int, bool]) -> bool:
    """Switch; tell whether a tuning has begun."""
    enabled, manual, tune = (named.get(offset) for offset in range(3))
    if enabled is False:
        loop.enabled, loop.released, loop.mode = False, True, 0
    elif enabled:
        loop.enabled = True
    if manual is False and loop.mode == 1:
        loop.mode = 0
    elif manual:
        loop.mode = 1
    if tune is False and loop.mode == 2:
        loop.enabled, loop.released, loop.mode = False, False, 0
    begins = bool(tune) and loop.mode != 2
    if begins:
        loop.mode = 2
    return begins


def span(table: dict[int, int], first: int, count: int) -> list[int]:
    """Return what is there, all of it."""
    try:
        return [table[first + i] for i in range(count)]
    except KeyError:
        raise Refusal(2) from None


def words(values: list[int]) -> bytes:
    """Count of bytes, and words."""
    return bytes([2 * len(values)]) + struct.pack(f">{len(values)}H", *values)


def pair(address: int, value: int) -> dict[int, int]:
    return {address: value >> 16, address + 1: value & 0xFFFF}
