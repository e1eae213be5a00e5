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
"""How long a read waits for bytes; short, so that Ctrl-C and `stop` act soon."""
LINES = "0"
"""Name of the console that shows the board's lines."""


def opened(port: str, hearing: Hearing) -> Serial:
    """Open a port as the spec says. Raises Refused: it cannot be opened."""
    from serial import Serial, SerialException  # noqa: PLC0415 - slow to import

    line = hearing.line
    try:
        return Serial(
            port, line.baud, parity=line.parity[0].upper(), stopbits=line.stop_bits, timeout=WAIT_S
        )
    except (SerialException, ValueError, OSError) as error:
        raise Refused(
            f"{port}: cannot be opened: {error}. Check that the board is plugged in, and that no "
            "other program uses the port; on Linux you must be in the group dialout."
        ) from None


def heard(port: Serial, hearing: Hearing, stop: Flag) -> Iterator[tuple[str, list[Reading]]]:
    """Yield each message of the board with its readings, until `stop` is set.

    While no complete message arrives, an empty one without readings is yielded after each read, so
    that the caller can check the time. Raises Refused: the port disappears.
    """
    from serial import SerialException  # noqa: PLC0415 - slow to import

    begun_s, asked_s, waiting = monotonic(), -hearing.every_s, bytearray()
    while not stop.is_set():
        now_s = monotonic() - begun_s
        try:
            if hearing.asks and now_s - asked_s >= hearing.every_s:
                asked_s = now_s
                port.write(hearing.asks)
            waiting += port.read(max(1, port.in_waiting))
        except (SerialException, OSError) as error:
            raise Refused(f"{port.name}: the serial line was lost: {error}") from None
        now_s = round(monotonic() - begun_s, 3)
        messages, rest = hearing.cut(bytes(waiting))
        waiting = bytearray(rest)
        for text in messages:
            yield text, list(hearing.read(text, now_s))
        if not messages:
            yield "", []


class Record:
    """A CSV file that `identify` reads; each reading is written at once."""

    def __init__(self, file: Path) -> None:
        """Create the file. Raises Refused: it exists already."""
        self.file = file
        try:
            with blaming(file):
                self._out: TextIO = file.open("x", encoding="utf-8")
        except FileExistsError:
            raise Refused(f"{file}: exists already and is not overwritten; name another.") from None
        self._out.write(HEAD)
        self.rows = 0

    def add(self, readings: Iterable[Reading]) -> None:
        """Write readings."""
        with blaming(self.file):
            for each in readings:
                cells = ("" if number is None else f"{number:.10g}" for number in each)
                self._out.write(",".join(cells) + "\n")
                self.rows += 1
            self._out.flush()

    def close(self) -> None:
        """Close the file."""
        with blaming(self.file):
            self._out.close()


def record(port: Serial, hearing: Hearing, file: Path, for_s: float, tell: Any) -> int:
    """Record readings for `for_s`, or until Ctrl-C; return how many were written.

    tell -- is called with the seconds so far and with `for_s`.
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
    """The data behind the page of `plot`: a serial line, or a recorded log.

    store -- the data for the browser's tabs; when_failed -- called when listening has ended with
    an error; failed -- that error.
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
        """Start a thread that listens."""

        def run() -> None:
            try:
                for text, readings in heard(port, hearing, self._stop):
                    if file is not None:
                        file.add(readings)
                    if text or readings:
                        self.tell(readings, [text] if text else [])
            except Exception as error:
                self.failed = error  # the command raises it once the server has ended
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
        """End the thread."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join()

    def order(self, order: Mapping[str, Any], answer: Callable[[str], None]) -> None:
        """Refuse any command: this page only shows data."""
        del order
        answer("This page accepts no commands.")

    def scenario(self) -> str:
        """Raise Unsaid: this page records no actions."""
        raise Unsaid("This page records no actions.")
