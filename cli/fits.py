"""A firmware that does not fit its board: by how much, what takes it, and what to do about it."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping
from copy import deepcopy
from typing import Any, NamedTuple, TypeAlias

from pydantic import ValidationError

from heatwright.cli.figures import build_json
from heatwright.generator import plan_firmware
from heatwright.generator.toolchain import BuildFailed, BuildResult, TooLarge
from heatwright.generator.toolchain.taken import NONE, Bytes
from heatwright.spec import BOARDS, Board, Controller, SerialLog, Spec
from heatwright.spec.checks import check
from heatwright.spec.checks.eeprom import on_board
from heatwright.spec.eeprom import layout
from heatwright.spec.problems import Path, dotted

LEAVE_OUT = "leave it out"
LIBRARY = "C library and start-up"
EVERY = "every firmware"
OTHER_CHIP = 1.1
"""The same firmware on another chip takes at most so many times the bytes: where a chip has more
memory, addresses of code and data are longer."""
ENTRY_BYTES = 4
MOST_WAYS = 6


Short: TypeAlias = tuple[bool, bool]
"""Whether flash is short, and whether RAM is."""


class Share(NamedTuple):
    """What a part of the spec takes: its key, none for what has no key."""

    path: Path
    what: str
    bytes: Bytes

    @property
    def name(self) -> str:
        """Return the key with its kind, or what it is."""
        return f"{dotted(self.path)} ({self.what})" if self.path and self.what else (
            dotted(self.path) or self.what
        )  # fmt: skip


class Way(NamedTuple):
    """A way to take less: what to change, the bytes that it saves, and whether it is enough."""

    key: str
    change: str
    saved: Bytes
    enough: bool


class DoesNotFit(BuildFailed):
    """The text for people; `as_json` has the same for machines."""

    def __init__(self, spec: Spec, error: TooLarge) -> None:
        self.built = error.built
        self.shares = shares(spec, error.taken, _short(error.built))
        self.boards = dict(boards_with_room(spec, error.built))
        self.ways = ways(spec.controller, self.shares, error.built)
        super().__init__(_text(spec, self), error.log)

    def as_json(self) -> dict[str, Any]:
        """Return the keys `build` and `too_large` of the JSON."""
        too_large = {
            "flash": max(0, self.built.flash_over),
            "ram": max(0, self.built.ram_over),
            "parts": [
                {
                    "key": dotted(each.path) or None,
                    "what": each.what or None,
                    **each.bytes._asdict(),
                }
                for each in self.shares
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


def shares(
    spec: Spec, taken: Mapping[str, Bytes], short: Short = (True, True)
) -> tuple[Share, ...]:
    """Add up what the source files take by the keys that want them, the largest first."""
    owners = {path.removeprefix("src/"): keys for path, keys in plan_firmware(spec).owners.items()}
    owners["main.c"] = ()
    found: defaultdict[tuple[Path, str], Bytes] = defaultdict(lambda: NONE)
    for name, each in taken.items():
        if name not in owners:
            found[(), LIBRARY] += each
        elif not owners[name]:
            found[(), EVERY] += each
        elif len(owners[name]) > 1:
            found[(), " and ".join(map(dotted, owners[name]))] += each
        else:
            (path,) = owners[name]
            found[path, _kind(spec.controller, path)] += each
    rows = (Share(path, what, each) for (path, what), each in found.items() if any(each))
    return tuple(sorted(rows, key=lambda row: (*_order(row.bytes, short), row.name)))


def _kind(controller: Controller, path: Path) -> str:
    match path:
        case ("interfaces", int(index)):
            return controller.interfaces[index].kind
        case ("sensors", str(name)):
            return controller.sensors[name].kind
        case ("outputs", str(name)):
            return controller.outputs[name].kind
        case ("loops", str(name), "algorithm"):
            return controller.loops[name].algorithm.kind
    return ""


def boards_with_room(spec: Spec, built: BuildResult) -> Iterator[tuple[str, bool]]:
    """List the boards that it fits with certainty; True: the spec is good for it as it is."""
    own = spec.controller.board
    for name, board in BOARDS.items():
        if name != own.name and _has_room(board, built, 1 if board.mcu == own.mcu else OTHER_CHIP):
            other = _on(spec, name)
            if other is not None:
                yield name, True
            elif _eeprom_has_room(spec.controller, name):
                yield name, False


def _has_room(board: Board, built: BuildResult, larger: float) -> bool:
    # On a chip with more than 128 KB of flash an address to return to takes 3 bytes instead of 2.
    stack = built.stack_bytes * (1 if larger == 1 else 1.5)
    return (
        built.flash_bytes * larger <= board.flash_bytes - board.bootloader_bytes
        and built.ram_bytes + stack <= board.ram_bytes
    )


def _on(spec: Spec, board: str) -> Controller | None:
    """Return the controller on another board; None where the checks refuse it."""
    data: Any = deepcopy(spec.tree.data)
    data["controller"]["board"] = board
    try:
        controller = Controller.model_validate(data)
    except ValidationError:
        return None
    return None if check(controller) else controller


def _eeprom_has_room(controller: Controller, board: str) -> bool:
    other = on_board(controller, board)
    return layout(other).end <= other.board.eeprom_bytes


def ways(controller: Controller, found: tuple[Share, ...], built: BuildResult) -> tuple[Way, ...]:
    """List what could be left out or made smaller, what saves most first."""
    keys: list[Path] = [("interfaces", index) for index in range(len(controller.interfaces))]
    keys += [("programs",)] * (controller.programs is not None)
    keys += [("loops", name, "autotune") for name in controller.loops]
    keys += [("loops", name) for name in controller.loops] * (len(controller.loops) > 1)
    result = [*_fewer_entries(controller, built)]
    for key in keys:
        saved = sum((each.bytes for each in found if each.path[: len(key)] == key), NONE)
        result.append(Way(dotted(key), LEAVE_OUT, saved, _enough(saved, built)))
    short = _short(built)
    useful = [way for way in result if any(b and s for b, s in zip(way.saved, short, strict=True))]
    useful.sort(key=lambda way: (way.change == LEAVE_OUT, *_order(way.saved, short)))
    return tuple(useful[:MOST_WAYS])


def _short(built: BuildResult) -> Short:
    return built.flash_over > 0, built.ram_over > 0


def _order(size: Bytes, short: Short) -> tuple[int, int]:
    """Sort by what is short; by flash where both are."""
    return (-size.flash if short[0] else 0, -size.ram)


def _enough(saved: Bytes, built: BuildResult) -> bool:
    return saved.flash >= built.flash_over and saved.ram >= built.ram_over


def _fewer_entries(controller: Controller, built: BuildResult) -> Iterator[Way]:
    for index, each in enumerate(controller.interfaces):
        if isinstance(each, SerialLog) and each.keep == "ram" and built.ram_over > 0:
            most = each.entries - math.ceil(built.ram_over / ENTRY_BYTES)
            if most > 0:
                saved = Bytes(0, (each.entries - most) * ENTRY_BYTES)
                key = f"interfaces[{index}].entries"
                yield Way(key, f"at most {most}", saved, _enough(saved, built))


def _text(spec: Spec, error: DoesNotFit) -> str:
    built = error.built
    board = spec.controller.identity.board
    lines = [f"{spec.file_name}: the firmware does not fit the {board}.", *balance(built), ""]
    rows = [(each.name, f"{each.bytes.flash:,}", f"{each.bytes.ram:,}") for each in error.shares]
    stack = ("stack at worst", "", f"{built.stack_bytes:,}")
    rows = [("What takes it, in bytes", "flash", "RAM"), *rows, stack]
    width = max(len(name) for name, _, _ in rows) + 1
    lines += [f"{name:{width}} {flash:>7} {ram:>6}".rstrip() for name, flash, ram in rows]
    lines += ["", _boards_text(error.boards)]
    if error.ways:
        lines += ["What saves most:", *map(_way_text, error.ways)]
    return "\n".join(lines)


def balance(built: BuildResult) -> list[str]:
    """Say of flash and RAM how much is there, how much is taken, and what is too much or free."""
    taken = f"{built.ram_bytes:,} B of variables and {built.stack_bytes:,} B of stack at worst"
    return [
        f"flash: {built.flash_bytes:,} of {built.flash_limit:,} B: {_rest(built.flash_over)}",
        f"RAM: {taken}, of {built.ram_limit:,} B: {_rest(built.ram_over)}",
    ]


def _rest(over: int) -> str:
    return f"{over:,} B too many" if over > 0 else f"{-over:,} B free"


def _boards_text(boards: Mapping[str, bool]) -> str:
    good = [name for name, as_it_is in boards.items() if as_it_is]
    other = [name for name, as_it_is in boards.items() if not as_it_is]
    if not boards:
        return "Boards with room: none that the language knows."
    said = [f"{', '.join(good)}, with the spec as it is"] * bool(good)
    said += [f"{', '.join(other)}, where `heatwright check` tells what else to change"] * bool(
        other
    )
    return f"Boards with room: {'; '.join(said)}."


def _way_text(way: Way) -> str:
    named = zip(way.saved, ("flash", "RAM"), strict=True)
    saved = " and ".join(f"{size:,} B of {memory}" for size, memory in named if size)
    return f"  {way.key}: {way.change}: {saved}{', enough alone' if way.enough else ''}"
