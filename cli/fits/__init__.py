"""A firmware that does not fit its board: the missing memory, the largest users, and remedies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from heatwright.cli.figures import build_json
from heatwright.cli.fits.ways import Share, Way, boards_with_room, shares, short_of, ways
from heatwright.generator.toolchain import BuildFailed, BuildResult, TooLarge
from heatwright.spec import Spec
from heatwright.spec.problems import dotted


@dataclass(frozen=True)
class Misfit:
    """All facts about a firmware that does not fit."""

    file: str
    board: str
    built: BuildResult
    shares: tuple[Share, ...]
    boards: Mapping[str, bool]
    """Boards with room; True: the spec is good for the board without other changes."""
    ways: tuple[Way, ...]

    def as_json(self) -> dict[str, Any]:
        """Return the keys `build` and `too_large` of the JSON."""
        too_large = {
            "flash": max(0, self.built.flash_over),
            "ram": max(0, self.built.ram_over),
            "parts": [
                {"key": dotted(path) or None, "what": what or None, **size._asdict()}
                for path, what, size in self.shares
            ],
            "boards": [
                {"board": name, "as_it_is": as_it_is} for name, as_it_is in self.boards.items()
            ],
            "savings": [
                {"key": way.key, "change": way.change, **way.saved._asdict(), "enough": way.enough}
                for way in self.ways
            ],
        }
        return {"build": build_json(self.built), "too_large": too_large}

    @property
    def text(self) -> str:
        """The facts as text."""
        lines = [f"{self.file}: the firmware does not fit the {self.board}.", *balance(self.built)]
        lines += ["", *self._table(), "", _boards_text(self.boards)]
        if self.ways:
            lines += ["Largest savings:", *map(_way_text, self.ways)]
        return "\n".join(lines)

    def _table(self) -> list[str]:
        sizes = [(each.name, f"{each.size.flash:,}", f"{each.size.ram:,}") for each in self.shares]
        rows = [
            ("Used by, in bytes", "flash", "RAM"),
            *sizes,
            ("stack at worst", "", f"{self.built.stack_bytes:,}"),
        ]
        width = max(len(name) for name, _, _ in rows)
        return [f"{name:{width}}  {flash:>7} {ram:>6}" for name, flash, ram in rows]


class DoesNotFit(BuildFailed):
    """Stops the command; the error can be pickled, so that a worker process can raise it, too."""

    def __init__(self, what: Misfit) -> None:
        super().__init__(what.text, what.built.log)
        self.what = what

    def __reduce__(self) -> tuple[type[DoesNotFit], tuple[Misfit]]:
        return DoesNotFit, (self.what,)


def misfit(spec: Spec, error: TooLarge) -> Misfit:
    """Collect all facts about a firmware that does not fit."""
    found = shares(spec, error.taken, short_of(error.built))
    return Misfit(
        file=spec.file_name,
        board=spec.controller.identity.board,
        built=error.built,
        shares=found,
        boards=dict(boards_with_room(spec, error.built)),
        ways=ways(spec.controller, found, error.built),
    )


def balance(built: BuildResult) -> list[str]:
    """Say for flash and RAM how much is used, how much there is, and how much is over or free."""
    taken = f"{built.ram_bytes:,} B of variables and {built.stack_bytes:,} B of stack at worst"
    return [
        f"flash: {built.flash_bytes:,} of {built.flash_limit:,} B: {_rest(built.flash_over)}",
        f"RAM: {taken}, of {built.ram_limit:,} B: {_rest(built.ram_over)}",
    ]


def _rest(over: int) -> str:
    return f"{over:,} B too many" if over > 0 else f"{-over:,} B free"


def _boards_text(boards: Mapping[str, bool]) -> str:
    good = ", ".join(name for name, as_it_is in boards.items() if as_it_is)
    other = ", ".join(name for name, as_it_is in boards.items() if not as_it_is)
    said = [f"{good}, with the spec as it is"] * bool(good)
    said += [f"{other}, after other changes that `heatwright check` names"] * bool(other)
    return f"Boards with room: {'; '.join(said) or 'none that the language knows'}."


def _way_text(way: Way) -> str:
    named = zip(way.saved, ("flash", "RAM"), strict=True)
    saved = " and ".join(f"{size:,} B of {memory}" for size, memory in named if size)
    return f"  {way.key}: {way.change}: {saved}{', enough alone' if way.enough else ''}"
