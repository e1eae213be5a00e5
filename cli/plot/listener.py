"""Listens to a serial line: for a page, for a file, or both."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from threading import Event as Flag
from threading import Thread
from time import monotonic
from typing import TYPE_CHECKING, Any, TextIO

from heatwright.cli.bench.recorded import Unsaid
from heatwright.cli.bench.store import Point, Store
from heatwright.cli.ends import Refused
from heatwright.cli.plot.hearing import Hearing, Reading
from heatwright.cli.targets import blaming

if TYPE_CHECKING:
    from serial import Serial

HEAD = "time_s,temperature_c,setpoint_c,duty_percent\n"
WAIT_S = 0.1
"""How long a read waits for bytes, so that the end is never far."""
LINES = "0"
"""The roll of what was said."""


def opened(port: str, hearing: Hearing) -> Serial:
    """Open a port as the spec says. Raises Refused where it cannot be had."""
    from serial import Serial, SerialException  # noqa: PLC0415 - takes a while

    line = hearing.line
    try:
        return Serial(
            port, line.baud, parity=line.parity[0].upper(), stopbits=line.stop_bits, timeout=WAIT_S
        )
    except (SerialException, ValueError, OSError) as error:
        raise Refused(
            f"{port}: cannot be opened: {error}. Look whether the board is plugged in, and no "
            "other program has the port; on Linux you must be of the group dialout."
        ) from None


def heard(port: Serial, hearing: Hearing, stop: Flag) -> Iterator[tuple[str, list[Reading]]]:
    """Yield each message of the board with what it tells, until `stop` is set.

    While no complete one arrives, an empty one without readings is yielded after each read, so
    that the caller can look at the time.

    Raises Refused where the port is gone.
    """
    from serial import SerialException  # noqa: PLC0415 - see opened

    begun_s, asked_s, waiting = monotonic(), -hearing.every_s, bytearray()
    while not stop.is_set():
        now_s = monotonic() - begun_s
        try:
            if hearing.asks and now_s - asked_s >= hearing.every_s:
                asked_s = now_s
                port.write(hearing.asks)
            waiting += port.read(max(1, port.in_waiting))
        except (SerialException, OSError) as error:
            raise Refused(f"{port.name}: the line is gone: {error}") from None
        now_s = round(monotonic() - begun_s, 3)
        messages, rest = hearing.cut(bytes(waiting))
        waiting = bytearray(rest)
        for text in messages:
            yield text, list(hearing.read(text, now_s))
        if not messages:
            yield "", []


class Record:
    """A file that `identify` reads; each reading is in it at once."""

    def __init__(self, file: Path) -> None:
        """Create it. Raises Refused where it is there already."""
        self.file = file
        try:
            with blaming(file):
                self._out: TextIO = file.open("x", encoding="utf-8")
        except FileExistsError:
            raise Refused(f"{file}: exists already and is not overwritten; name another.") from None
        self._out.write(HEAD)
        self.rows = 0

    def add(self, readings: Iterable[Reading]) -> None:
        """Write what was read."""
        with blaming(self.file):
            for each in readings:
                cells = ("" if number is None else f"{number:.10g}" for number in each)
                self._out.write(",".join(cells) + "\n")
                self.rows += 1
            self._out.flush()

    def close(self) -> None:
        """End it."""
        with blaming(self.file):
            self._out.close()


def record(port: Serial, hearing: Hearing, file: Path, for_s: float, tell: Any) -> int:
    """Write what a line tells to a file, for so long or until Ctrl-C; return how many readings.

    tell -- is called with the seconds so far, and how long it will be.
    """
    found, stop, begun_s = Record(file), Flag(), monotonic()
    try:
        for _, readings in heard(port, hearing, stop):
            found.add(readings)
            took_s = monotonic() - begun_s
            tell(min(took_s, for_s), for_s)
            if took_s >= for_s:
                stop.set()
    except KeyboardInterrupt:
        pass  # stopped by the user: the rows recorded so far are fitted
    finally:
        found.close()
    return found.rows


class Shown:
    """What a page of courses shows: a line that is listened to, or a log that was recorded.

    store -- what the tabs are told; when_failed -- called when
    listening has ended with an error, failed -- that error.
    """

    page = "plot.html"

    def __init__(self, about: Mapping[str, Any], loop: str) -> None:
        self.store = Store(about)
        self.failed: Exception | None = None
        self.when_failed: Callable[[], None] = lambda: None
        self._loop = loop
        self._last: Mapping[str, Any] = {}
        self._stop = Flag()
        self._thread: Thread | None = None

    def listen(self, port: Serial, hearing: Hearing, file: Record | None) -> None:
        """Begin to listen, in a thread."""

        def run() -> None:
            try:
                for text, readings in heard(port, hearing, self._stop):
                    if file is not None:
                        file.add(readings)
                    if text or readings:
                        self.tell(readings, [text] if text else [])
            except Exception as error:
                self.failed = error  # raised by whoever waits for this thread
                self.when_failed()

        self._thread = Thread(target=run, name="line", daemon=True)
        self._thread.start()

    def tell(self, readings: Sequence[Reading], lines: Sequence[str] = ()) -> None:
        """Show readings and lines."""
        points: list[Point] = [
            (each.time_s, each.temperature_c, None, each.setpoint_c, each.duty_percent)
            for each in readings
        ]
        for each in readings:
            self._last = each._asdict()
        self.store.publish(self._last, {self._loop: points}, {LINES: list(lines)}, None)

    def stop(self) -> None:
        """Let it come to its end."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join()

    def order(self, order: Mapping[str, Any], answer: Callable[[str], None]) -> None:
        """Refuse: this page only shows."""
        del order
        answer("There is nothing to order here.")

    def scenario(self) -> str:
        """Raise Unsaid: nobody does anything here."""
        raise Unsaid("Nothing is done here.")
