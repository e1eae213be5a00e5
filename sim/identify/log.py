"""Read the rows of numbers of a log, whatever program wrote it and whatever else it contains."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.identify.cells import DIALECTS, Dialect, fields, labelled, unstamped, value
from heatwright.sim.trace import Series


class Unusable(ValueError):
    """A log from which no plant can be found; the text says why, and what to do about it."""


LARGEST_LOG = 64 << 20
"""Maximum size, bytes: a day at ten lines a second takes less."""

SAMPLE = 500
"""Number of lines from which the format of a log is determined."""

DAY_S = 86400.0
STAMP = "time stamp [s]"
"""Name of the column of clock times before the lines."""


@dataclass(frozen=True)
class Log:
    """A table of numbers; gaps are NaN."""

    names: tuple[str, ...]
    """Names of the columns; empty if the log has none."""
    values: NDArray[np.float64]
    """One row for each line of numbers."""
    dropped: int
    """Number of lines that were something else."""
    stamped: bool = False
    """Whether the last column has the clock times that stood before the lines."""


def read_log(data: bytes) -> Log:
    """Parse a log. Raises Unusable: it holds no rows of numbers."""
    if len(data) > LARGEST_LOG:
        raise Unusable(f"is larger than {LARGEST_LOG >> 20} MB; cut out the part with the step")
    lines = [line for line in _text(data).splitlines() if line.strip()]
    stamps, bare = _unstamped(lines)
    sample = bare[:: max(1, len(bare) // SAMPLE)]
    of_labels = sum(len(labelled(line)) > 1 for line in sample)
    dialect, width, count = _form(sample)
    if max(of_labels, count) < 1:
        raise Unusable(
            "has no rows of numbers; a log has one line for each reading, such as 20.5,100"
        )
    if of_labels > count:
        return _of_labels(bare, stamps)
    return _of_fields(bare, stamps, dialect, width)


def _text(data: bytes) -> str:
    if data[:2] in {b"\xff\xfe", b"\xfe\xff"}:
        return data.decode("utf-16", errors="replace")
    return data.decode("utf-8-sig", errors="replace").replace("\0", "")


def _unstamped(lines: Sequence[str]) -> tuple[list[float | None], list[str]]:
    """Remove the clock times, if more than half of the lines have one before other fields."""
    pairs = [unstamped(line) for line in lines]
    if 2 * sum(stamp is not None for stamp, _ in pairs) <= len(lines):
        return [None] * len(lines), list(lines)
    return [stamp for stamp, _ in pairs], [rest for _, rest in pairs]


def _form(sample: Sequence[str]) -> tuple[Dialect, int, int]:
    """Return the dialect of most lines, their number of fields, and the number of such lines."""
    best = (DIALECTS[0], 0, 0)
    for dialect in DIALECTS:
        widths = Counter(
            len(cells) for line in sample if (cells := _numbers(line, dialect)) is not None
        )
        if widths:
            width, count = max(widths.items(), key=lambda item: (item[1], item[0]))
            if (count, width) > (best[2], best[1]):
                best = (dialect, width, count)
    return best


def _numbers(line: str, dialect: Dialect) -> list[float] | None:
    """Read a line of numbers; None if any field is something else, or all are gaps."""
    cells = [value(text, dialect) for text in fields(line, dialect)]
    found = [cell for cell in cells if cell is not None]
    if len(found) < len(cells) or all(map(math.isnan, found)):
        return None
    return found


def _of_fields(
    lines: Sequence[str], stamps: Sequence[float | None], dialect: Dialect, width: int
) -> Log:
    names: tuple[str, ...] = ()
    rows: list[list[float]] = []
    kept: list[float | None] = []
    headers = 0
    for line, stamp in zip(lines, stamps, strict=True):
        cells = _numbers(line, dialect)
        if cells is not None and len(cells) == width:
            rows.append(cells)
            kept.append(stamp)
        elif cells is None and not rows:
            titles = tuple(fields(line.lstrip("#"), dialect))
            if len(titles) == width and all(titles):
                names, headers = titles, 1
    return _log(names, rows, kept, len(lines) - len(rows) - headers)


def _of_labels(lines: Sequence[str], stamps: Sequence[float | None]) -> Log:
    found = [(labelled(line), stamp) for line, stamp in zip(lines, stamps, strict=True)]
    counts = Counter(name for row, _ in found for name in row)
    most = max(counts.values())
    names = tuple(name for name, count in counts.items() if 2 * count > most)
    kept = [(row, stamp) for row, stamp in found if any(name in row for name in names)]
    rows = [[row.get(name, math.nan) for name in names] for row, _ in kept]
    return _log(names, rows, [stamp for _, stamp in kept], len(lines) - len(rows))


def _log(
    names: tuple[str, ...], rows: list[list[float]], stamps: list[float | None], dropped: int
) -> Log:
    values = np.array(rows, dtype=np.float64)
    stamped = any(stamp is not None for stamp in stamps)
    if stamped:
        values = np.column_stack([values, unwrapped(np.array(stamps, np.float64))])
        names = (*names, STAMP) if names else ()
    return Log(names, values, dropped, stamped)


def unwrapped(times_s: Series) -> Series:
    """Add a day to times of day, s, after each midnight."""
    midnights = np.diff(times_s, prepend=times_s[:1]) < -DAY_S / 2
    return times_s + DAY_S * np.cumsum(midnights)
