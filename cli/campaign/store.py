"""A campaign's folder: keeps each finished run, and refuses runs of another campaign."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from filelock import FileLock, Timeout

from heatwright.cli.ends import Refused
from heatwright.cli.targets import blaming, whole

if TYPE_CHECKING:
    from heatwright.cli.campaign.work import Task
    from heatwright.sim.campaign.outcome import Row

IDENTITY, JOURNAL, LOCK, TABLE = "campaign.json", "runs.jsonl", ".lock", "runs.parquet"
TEXTS = frozenset({"outcome", "rule", "too_hot", "drawn.fault", "drawn.fault.loop"})
"""Columns of text; all others are numbers."""


def fingerprint(*parts: Any) -> str:
    """Return a hash of 16 hex digits of bytes, or of values that JSON can have."""
    found = sha256()
    for part in parts:
        data = part if isinstance(part, bytes) else json.dumps(part, sort_keys=True).encode()
        found.update(data)
    return found.hexdigest()[:16]


def identity(task: Task) -> dict[str, str | int]:
    """Return the values by which campaigns differ: spec, variations, seed, firmware, version."""
    from heatwright.cli.campaign.work import program_of  # noqa: PLC0415

    return {
        "spec": fingerprint(task.controller.model_dump(by_alias=True, exclude={"comparison"})),
        "vary": fingerprint(task.vary.model_dump(by_alias=True)),
        "seed": task.seed,
        "firmware": fingerprint(program_of(task.elf).flash),
        "heatwright": task.heatwright,
    }


class Store:
    """The runs of one campaign.

    rows -- the finished runs, by number; identity -- the values by which campaigns differ.
    """

    def __init__(self, folder: Path, identity: dict[str, str | int]) -> None:
        self.folder, self._identity = folder, identity
        self.rows: dict[int, Row] = {}

    @contextmanager
    def opened(self) -> Iterator[None]:
        """Lock the folder for this command. Raises Refused: it contains another campaign."""
        with blaming(self.folder):
            self.folder.mkdir(exist_ok=True)
        lock = FileLock(self.folder / LOCK)
        try:
            lock.acquire(timeout=0)
        except Timeout:
            raise Refused(
                f"{self.folder}: another command is running this campaign. Wait for its end, or "
                "name another folder with --output."
            ) from None
        try:
            self._begin()
            with blaming(self._journal), self._journal.open("ab") as self._file:
                yield
        finally:
            lock.release()

    @property
    def _journal(self) -> Path:
        return self.folder / JOURNAL

    def _begin(self) -> None:
        file = self.folder / IDENTITY
        if file.is_file():
            self._compare(json.loads(file.read_text(encoding="utf-8")))
        elif any(each.name != LOCK for each in self.folder.iterdir()):
            raise Refused(
                f"{self.folder}: has other files and no campaign. Name another folder with "
                "--output."
            )
        else:
            with whole(file) as fresh:
                fresh.write_text(json.dumps(self._identity, indent=2) + "\n", encoding="utf-8")
        self._read()

    def _compare(self, kept: dict[str, Any]) -> None:
        other = [what for what, value in self._identity.items() if kept.get(what) != value]
        if other:
            raise Refused(
                f"{self.folder}: has runs of another {' and another '.join(other)}, which must "
                "not be mixed with new runs. Name another folder with --output, or delete this one."
            )

    def _read(self) -> None:
        """Read the finished runs; drop a last line that was cut off."""
        if not self._journal.exists():
            return
        data = self._journal.read_bytes()
        sound = data[: data.rfind(b"\n") + 1]
        if len(sound) < len(data):
            os.truncate(self._journal, len(sound))
        for line in sound.splitlines():
            row = json.loads(line)
            self.rows[row["run"]] = row

    def keep(self, row: Row) -> None:
        """Write a finished run to the file at once."""
        number = row["run"]
        assert isinstance(number, int)  # noqa: S101 - the number of the run
        if number in self.rows:
            return
        self.rows[number] = row
        self._file.write(json.dumps(row, allow_nan=False, separators=(",", ":")).encode() + b"\n")
        self._file.flush()

    def table(self, runs: int) -> list[Row]:
        """Return the runs 0 to `runs` - 1, in order."""
        return [self.rows[number] for number in range(runs)]

    def write_table(self, rows: list[Row]) -> Path:
        """Write runs as a Parquet file, and return its path: equal rows give equal bytes."""
        import pyarrow as pa  # noqa: PLC0415 - an extra of this package
        from pyarrow import parquet  # noqa: PLC0415

        def kind(name: str) -> Any:
            if name == "run":
                return pa.int64()
            return pa.string() if name in TEXTS else pa.float64()

        columns = list(rows[0])
        schema = pa.schema([(name, kind(name)) for name in columns])
        table = pa.table({name: [row[name] for row in rows] for name in columns}, schema=schema)
        file = self.folder / TABLE
        with whole(file) as fresh:
            parquet.write_table(table, fresh)
        return file
