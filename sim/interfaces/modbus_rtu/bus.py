"""A Modbus line, RS-232 or RS-485, at the pins of a UART and of its driver."""

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

from numpy.typing import NDArray

from heatwright.sim.avr import Avr
from heatwright.sim.native.characters import Format, receiver, sent_by

FIXED_ABOVE_BAUD = 19_200
FIXED_SILENCE_S = 1.75e-3
"""Above 19200 baud silence has a fixed length (serial line 1.02, 2.5.1.1)."""
SILENT_CHARACTERS = 3.5


def silence_s(baud: int, character_bits: int) -> float:
    """Return the silence that ends a frame, s."""
    if baud > FIXED_ABOVE_BAUD:
        return FIXED_SILENCE_S
    return SILENT_CHARACTERS * character_bits / baud


@dataclass(frozen=True)
class Frame:
    """Bytes from the board between two silences.

    start_s, end_s -- its first start bit and its last stop bit; whole -- whether parity and stop
    bit of each byte are right; longest_gap_s -- the longest time between two of its bytes.
    """

    start_s: float
    end_s: float
    data: bytes
    whole: bool
    longest_gap_s: float


class _Byte(NamedTuple):
    start_s: float
    end_s: float
    value: int
    format: int
    bit_cycles: int


class Bus:
    """A line with one master and one slave.

    unheard -- bytes the board sent while its driver was off; collisions -- how often it switched
    the driver on while the master sent; slowest_release_s -- longest time from the end of an answer
    until the driver was off.
    """

    def __init__(self, avr: Avr, uart: int, baud: int, form: Format, driver: int | None) -> None:
        """Connect a UART and, if any, the pin (number) that switches the driver to sending."""
        self.baud, self.form = baud, form
        self.silence_s = silence_s(baud, form.bits)
        self.unheard = self.collisions = 0
        self.slowest_release_s = 0.0
        self._avr = avr
        self.uart = uart
        self._uart = avr.uarts[uart]
        self._driver = driver
        self._driven: deque[tuple[float, bool]] = deque([(0.0, driver is None)])
        self._coming: list[_Byte] = []
        self._frame: list[_Byte] = []
        self._quiet_s = 0.0

    def send(
        self,
        data: bytes,
        *,
        baud: float | None = None,
        form: Format | None = None,
        gap_s: float | Sequence[float] = 0.0,
        flips: Sequence[int] = (),
    ) -> float:
        """Send bytes to the board after those that wait; return the end time of the last, s."""
        form, baud = form or self.form, baud or self.baud
        gaps_s = sum(gap_s) if isinstance(gap_s, Sequence) else gap_s * len(data)
        self._quiet_s = max(self._quiet_s, self._avr.time_s)
        self._quiet_s += gaps_s + len(data) * form.bits / baud
        self._uart.send(data, baud, form, gap_s=gap_s, flips=flips)
        return self._quiet_s

    @property
    def has_heard(self) -> bool:
        """Whether an answer has begun, or the board has sent anything, even by another UART."""
        return self.hears or len(self._avr.uarts.log) > 0

    @property
    def hears(self) -> bool:
        """Whether an answer has begun."""
        return bool(self._frame or self._coming)

    def feed(self, pins: NDArray[Any], sent: NDArray[Any]) -> list[Frame]:
        """Process pin changes and bytes of the UARTs; return the frames that have ended."""
        if len(pins):
            self._follow(pins)
        if len(sent):
            self._coming += self._bytes(sent)
        now_s = self._avr.time_s
        found: list[Frame] = []
        ended = sum(byte.end_s <= now_s for byte in self._coming)
        for byte in self._coming[:ended]:
            self._take(byte, found)
        del self._coming[:ended]
        if not self._coming:
            self._close(now_s, found)
        return found

    def _bytes(self, sent: NDArray[Any]) -> Iterator[_Byte]:
        clock_hz, mine = self._avr.clock_hz, sent_by(self.uart, sent)
        columns = (mine[name].tolist() for name in ("end", "value", "format", "bit_cycles"))
        bits = {code: Format.of(code).bits for code in set(mine["format"].tolist())}
        for end, value, code, bit in zip(*columns, strict=True):
            yield _Byte((end - bits[code] * bit) / clock_hz, end / clock_hz, value, code, bit)

    def _take(self, byte: _Byte, found: list[Frame]) -> None:
        if self._driver is not None and not self._is_driven(byte.start_s, byte.end_s):
            self.unheard += 1
            return
        self._close(byte.start_s, found)
        self._frame.append(byte)

    def _close(self, until_s: float, found: list[Frame]) -> None:
        if self._frame and until_s - self._frame[-1].end_s > self.silence_s:
            self._see_release(self._frame[-1].end_s)
            found.append(self._framed())
            self._frame = []

    def _framed(self) -> Frame:
        bit = self._avr.clock_hz / self.baud
        sent = {(byte.format, byte.bit_cycles) for byte in self._frame}
        heard = {how: receiver(*how, self.form, bit) for how in sent}
        read = [heard[byte.format, byte.bit_cycles][byte.value] for byte in self._frame]
        gaps = [later.start_s - byte.end_s for byte, later in pairwise(self._frame)]
        return Frame(
            self._frame[0].start_s,
            self._frame[-1].end_s,
            bytes(value for value, _ in read),
            all(right for _, right in read),
            max(gaps, default=0.0),
        )

    # -- the driver ----------------------------------------------------------------------------

    def _follow(self, pins: NDArray[Any]) -> None:
        if self._driver is None:
            return
        for event in pins[pins["pin"] == self._driver]:
            time_s, high = int(event["cycle"]) / self._avr.clock_hz, bool(event["state"] & 1)
            if high and time_s < self._quiet_s:
                self.collisions += 1
            self._driven.append((time_s, high))

    def _is_driven(self, start_s: float, end_s: float) -> bool:
        """Return whether the driver was on for all of a byte."""
        while len(self._driven) > 1 and self._driven[1][0] <= start_s:
            self._driven.popleft()
        if len(self._driven) == 1:
            return self._driven[0][1]
        return self._driven[0][1] and self._driven[1][0] >= end_s

    def _see_release(self, end_s: float) -> None:
        if self._driver is None:
            return
        off = (time_s for time_s, high in self._driven if not high and time_s >= end_s)
        late_s = next(off, self._avr.time_s) - end_s
        self.slowest_release_s = max(self.slowest_release_s, late_s)
