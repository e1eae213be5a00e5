"""Remedies for a firmware that does not fit: other boards, and its largest parts to leave out."""

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping
from copy import deepcopy
from typing import Any, NamedTuple, TypeAlias

from pydantic import ValidationError

from heatwright.generator import plan_firmware
from heatwright.generator.toolchain import BuildResult
from heatwright.generator.toolchain.taken import NONE, Bytes
from heatwright.spec import BOARDS, Board, Controller, Spec
from heatwright.spec.board.eeprom import layout
from heatwright.spec.board.serial_log import log_entry_bytes, logs_in_ram
from heatwright.spec.checks import check
from heatwright.spec.checks.board.eeprom import on_board
from heatwright.spec.checks.board.memory import POINT_BYTES
from heatwright.spec.problems import Path, dotted

LIBRARY = "C library and start-up"
EVERY = "every firmware"

Short: TypeAlias = tuple[bool, bool]
"""Whether the flash is too small, and whether the RAM is."""


class Share(NamedTuple):
    """The memory of one part of the spec; its path is empty if it belongs to no single key."""

    path: Path
    what: str
    size: Bytes

    @property
    def name(self) -> str:
        """Return the key with its kind, or a description."""
        if not self.path:
            return self.what
        return f"{dotted(self.path)} ({self.what})" if self.what else dotted(self.path)


def shares(
    spec: Spec, taken: Mapping[str, Bytes], short: Short = (True, True)
) -> tuple[Share, ...]:
    """Add up the sizes of the source files by the keys that need them, the largest share first."""
    owners = {path.removeprefix("src/"): keys for path, keys in plan_firmware(spec).owners.items()}
    owners["main.c"] = ()
    found: defaultdict[tuple[Path, str], Bytes] = defaultdict(lambda: NONE)
    for name, size in taken.items():
        keys = owners.get(name)
        if keys is None:
            found[(), LIBRARY] += size
        elif len(keys) == 1:
            found[keys[0], _kind(spec.controller, keys[0])] += size
        else:
            found[(), ", ".join(map(dotted, keys)) or EVERY] += size
    rows = (Share(path, what, size) for (path, what), size in found.items() if any(size))
    return tuple(sorted(rows, key=lambda row: (*in_order(row.size, short), row.name)))


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


def short_of(built: BuildResult) -> Short:
    """Return whether the flash is too small, and whether the RAM is."""
    return built.flash_over > 0, built.ram_over > 0


def in_order(size: Bytes, short: Short) -> tuple[int, int]:
    """Return a key to sort sizes, the largest first, by the memory that is too small."""
    return (-size.flash if short[0] else 0, -size.ram if short[1] else 0)


LEAVE_OUT = "leave it out"
SELF_CHECKS: Path = ("safety", "self_checks")
OTHER_CHIP = 1.1
"""Largest ratio of a firmware's flash on another chip to that on its own: with more memory, calls
and addresses are longer."""
OTHER_STACK = 1.5
"""Largest ratio of the stacks: with more memory a return address takes 3 bytes, not 2."""
MOST_WAYS = 6


class Way(NamedTuple):
    """A way to save memory: the change, the bytes that it saves, and whether it is enough."""

    key: str
    change: str
    saved: Bytes
    enough: bool


def boards_with_room(spec: Spec, built: BuildResult) -> Iterator[tuple[str, bool]]:
    """List boards that the firmware fits with certainty; True: the spec needs no other change."""
    own = spec.controller.board
    for name, board in BOARDS.items():
        if name == own.name or not _has_room(board, built, same=board.mcu == own.mcu):
            continue
        if _accepted(spec, name):
            yield name, True
        else:
            other = on_board(spec.controller, name)
            if layout(other).end <= other.board.eeprom_bytes:
                yield name, False


def _has_room(board: Board, built: BuildResult, *, same: bool) -> bool:
    flash = built.flash_bytes * (1 if same else OTHER_CHIP)
    ram = built.ram_bytes + built.stack_bytes * (1 if same else OTHER_STACK)
    return flash <= board.flash_bytes - board.bootloader_bytes and ram <= board.ram_bytes


def _accepted(spec: Spec, board: str) -> bool:
    """Return whether the spec passes all checks with another board."""
    data: Any = deepcopy(spec.tree.data)
    data["controller"]["board"] = board
    try:
        return not check(Controller.model_validate(data))
    except ValidationError:
        return False


def ways(controller: Controller, found: tuple[Share, ...], built: BuildResult) -> tuple[Way, ...]:
    """List numbers to reduce, then parts to leave out, the largest saving first."""
    keys: list[Path] = [("interfaces", index) for index in range(len(controller.interfaces))]
    keys += [("programs",), SELF_CHECKS]
    keys += [("loops", name, "autotune") for name in controller.loops]
    keys += [("loops", name) for name in controller.loops] * (len(controller.loops) > 1)
    left_out = []
    for key in keys:
        saved = sum((each.size for each in found if each.path[: len(key)] == key), NONE)
        change = "false" if key == SELF_CHECKS else LEAVE_OUT
        left_out.append(Way(dotted(key), change, saved, _enough(saved, built)))
    short = short_of(built)
    useful = [way for way in left_out if in_order(way.saved, short) != (0, 0)]
    useful.sort(key=lambda way: in_order(way.saved, short))
    return (*_fewer(controller, built), *useful)[:MOST_WAYS]


def _fewer(controller: Controller, built: BuildResult) -> Iterator[Way]:
    """List the numbers of the spec that decide the use of RAM, each with a value that fits."""
    for index, each in logs_in_ram(controller).items():
        bytes_each = log_entry_bytes(controller, each)
        yield from _at_most(f"interfaces[{index}].entries", each.entries, 1, bytes_each, built)
    if controller.programs is not None:
        stored = max((len(each.segments) for each in controller.programs.stored), default=1)
        points = controller.programs.points
        yield from _at_most("programs.points", points, stored, POINT_BYTES, built)


def _at_most(key: str, number: int, least: int, each: int, built: BuildResult) -> Iterator[Way]:
    """Propose a smaller number, of items that take at least `each` bytes of RAM."""
    fewer = math.ceil(built.ram_over / each)
    if 0 < fewer <= number - least:
        saved = Bytes(0, fewer * each)
        yield Way(key, f"at most {number - fewer}", saved, _enough(saved, built))


def _enough(saved: Bytes, built: BuildResult) -> bool:
    return saved.flash >= built.flash_over and saved.ram >= built.ram_over
