"""An HD44780 display controller of 16 x 2 characters (Hitachi data sheet ADE-207-272(Z)).

It is only written to (R/W grounded), so its busy flag is never read: writes that come too early
are lost, and counted.
"""

from __future__ import annotations

from codecs import charmap_decode
from dataclasses import dataclass

OWN = "■"
"""Placeholder for a character that the program has drawn itself (codes 0 to 15)."""

_ASCII = "".join(map(chr, range(0x20, 0x7E))).replace("\\", "¥") + "→←"
_KATAKANA = "".join(map(chr, range(0xFF61, 0xFF9F))) + "°"
_REST = "αäβεμσρg√⁻jˣ¢£ñöpqθ∞ΩüΣπx̄y千万円÷ █"
"""Codes 0xE0 to 0xFF; the x with a bar takes two characters and is replaced by an x."""

A00 = OWN * 16 + " " * 16 + _ASCII + " " * 32 + " " + _KATAKANA + _REST.replace("x̄", "x")
"""The characters of ROM A00, by code (data sheet, table 4).

Programs use code 0xDF, the katakana voicing circle, as degree sign.
"""


WIDTH = 16
LINE_LENGTH = 40
LINE_STARTS = (0x00, 0x40)
UNCONNECTED = 0xF
"""D3..D0 of a display wired with four data lines: pulled up inside."""


def _order(*rows: range) -> tuple[list[int], dict[int, int]]:
    """Return the addresses in the cursor's order, and the place of each."""
    places = [address for row in rows for address in row]
    return places, {address: place for place, address in enumerate(places)}


_TWO_ROWS = _order(*(range(start, start + LINE_LENGTH) for start in LINE_STARTS))
_ONE_ROW = _order(range(2 * LINE_LENGTH))


@dataclass(frozen=True)
class Times:
    """Execution times, ns, at an internal oscillator of 270 kHz; from 190 to 350 kHz is allowed."""

    power_on: int = 15_000_000
    clear: int = 1_520_000
    other: int = 37_000
    data: int = 41_000

    def at(self, oscillator_hz: float) -> Times:
        """Return the times for another oscillator; the wait at power-on does not depend on it."""
        factor = 270_000 / oscillator_hz
        return Times(
            self.power_on,
            round(self.clear * factor),
            round(self.other * factor),
            round(self.data * factor),
        )


class Hd44780:
    """The display controller; its bus calls ``write(time_ns, rs, nibble)`` at each fall of E.

    lost -- writes without effect because it was busy; text -- the characters it shows.
    """

    def __init__(self, times: Times | None = None) -> None:
        self.times = times or Times()
        self.lost = 0
        self.power_on(0)

    def power_on(self, time_ns: int) -> None:
        """Start again: 8-bit bus, one line, display off, cleared, busy for a while."""
        self._ddram = bytearray(b" " * 0x80)
        self._cgram = bytearray(64)
        self._eight_bit = True
        self._two_lines = False
        self._on = False
        self._increment = 1
        self._shifts = False
        self._shift = 0
        self._address = 0
        self._in_cgram = False
        self._high: int | None = None
        self._busy_until = time_ns + self.times.power_on

    @property
    def ready(self) -> bool:
        """Whether it is set to four data lines and two rows, and is on."""
        return self._on and self._two_lines and not self._eight_bit

    @property
    def text(self) -> tuple[str, str]:
        """The two rows of 16 characters; blank while it is off."""
        if not self._on:
            return " " * WIDTH, " " * WIDTH
        first, second = (self._row(start) for start in LINE_STARTS)
        return first, second if self._two_lines else " " * WIDTH

    def _row(self, start: int) -> str:
        line = self._ddram[start : start + LINE_LENGTH]
        shown = (line + line)[self._shift : self._shift + WIDTH]
        return charmap_decode(shown, "strict", A00)[0]

    def write(self, time_ns: int, rs: int, nibble: int) -> bool:
        """Read D7..D4 at a falling edge of E; return whether the shown text may change."""
        if time_ns < self._busy_until:
            self.lost += 1
            return False
        if self._eight_bit:
            return self._take(time_ns, rs, nibble << 4 | UNCONNECTED)
        if self._high is None:
            self._high = nibble
            return False
        byte, self._high = self._high << 4 | nibble, None
        return self._take(time_ns, rs, byte)

    def _take(self, time_ns: int, rs: int, byte: int) -> bool:
        if rs:
            self._busy_until = time_ns + self.times.data
            return self._data(byte)
        slow = byte in {0x01, 0x02, 0x03}
        if byte:
            _INSTRUCTIONS[byte.bit_length() - 1](self, byte)
        self._busy_until = time_ns + (self.times.clear if slow else self.times.other)
        return byte < 0x40  # those from 0x40 on only set an address

    def _clear(self, _: int) -> None:
        self._ddram[:] = b" " * len(self._ddram)
        self._increment = 1
        self._home(0)

    def _home(self, _: int) -> None:
        self._address = self._shift = 0
        self._in_cgram = False

    def _entry_mode(self, byte: int) -> None:
        self._increment = 1 if byte & 2 else -1
        self._shifts = bool(byte & 1)

    def _display_control(self, byte: int) -> None:
        self._on = bool(byte & 4)

    def _move(self, byte: int) -> None:
        right = bool(byte & 4)
        if byte & 8:
            self._shift = (self._shift + (-1 if right else 1)) % LINE_LENGTH
        else:
            self._step(1 if right else -1)

    def _function_set(self, byte: int) -> None:
        self._eight_bit = bool(byte & 0x10)
        self._two_lines = bool(byte & 8)
        self._high = None

    def _cgram_address(self, byte: int) -> None:
        self._address = byte & 0x3F
        self._in_cgram = True

    def _ddram_address(self, byte: int) -> None:
        self._address = byte & 0x7F
        self._in_cgram = False

    def _data(self, byte: int) -> bool:
        """Write a character; return whether it changes the shown text: most writes do not."""
        shows = False
        if self._in_cgram:
            self._cgram[self._address & 0x3F] = byte
        else:
            shows = self._shifts or self._ddram[self._address] != byte
            self._ddram[self._address] = byte
            if self._shifts:
                self._shift = (self._shift + self._increment) % LINE_LENGTH
        self._step(self._increment)
        return shows

    def _step(self, by: int) -> None:
        if self._in_cgram:
            self._address = (self._address + by) & 0x3F
            return
        places, place_of = _TWO_ROWS if self._two_lines else _ONE_ROW
        place = place_of.get(self._address, 0)
        self._address = places[(place + by) % len(places)]


_INSTRUCTIONS = (
    Hd44780._clear,
    Hd44780._home,
    Hd44780._entry_mode,
    Hd44780._display_control,
    Hd44780._move,
    Hd44780._function_set,
    Hd44780._cgram_address,
    Hd44780._ddram_address,
)
"""Instructions by the number of the highest bit that is set."""
