"""The flash and RAM that each part of a spec takes."""

from collections import defaultdict
from collections.abc import Mapping
from typing import NamedTuple, TypeAlias

from heatwright.generator import plan_firmware
from heatwright.generator.toolchain import BuildResult
from heatwright.generator.toolchain.taken import NONE, Bytes
from heatwright.spec import Controller, Spec
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
