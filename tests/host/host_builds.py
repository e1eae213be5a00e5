"""Host builds of projects, each made once (`build/rig`), by all that goes into it."""

import hashlib
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import host_specs
from rig.firmware import kept

from heatwright.generator import plan_firmware, render, write
from heatwright.sim.host import HostBuild, build_host
from heatwright.sim.host import __file__ as package
from heatwright.sim.host.parts import parts_of
from heatwright.spec import Spec


@cache
def build_of(name: str, *, sanitized: bool = True) -> HostBuild:
    """Return the build of one of `host_specs`.

    Args:
        name: of the specification.
        sanitized: else without gcc's sanitizer, which would end the process at a mutant's first
            overflow.

    """
    return build_of_spec(host_specs.spec_of(name), sanitized=sanitized)


@cache
def build_of_spec(spec: Spec, *, sanitized: bool = True) -> HostBuild:
    """Return the build of any specification of one loop."""
    files = render(plan_firmware(spec))
    key = repr((sorted(files.items()), sanitized)).encode() + _world()

    def build(folder: Path) -> None:
        write(files, folder / "project")
        build_host(folder / "project", spec.controller, folder / "made", sanitized=sanitized)

    place = kept(f"host-{hashlib.sha256(key).hexdigest()[:24]}", "made/host.so", build)
    objects = {f"{made.stem}.c": made for made in (place / "made").glob("*.o")}
    return HostBuild(
        place / "made" / "host.so", place / "project", spec.controller,
        parts_of(spec.controller), sanitized, objects,
    )  # fmt: skip


@cache
def _world() -> bytes:
    """What else goes into a build: the world, and how it is compiled."""
    folder = Path(package).parent
    return b"".join(
        path.read_bytes() for path in sorted(folder.rglob("*.[chp]*")) if path.is_file()
    )


def sources_of(build: HostBuild) -> Mapping[str, str]:
    """The firmware's C that is in a build, and all its headers."""
    source = build.project / "src"
    chosen = [
        path for path in source.iterdir() if path.suffix == ".h" or path.name in build.objects
    ]
    return {path.name: path.read_text(encoding="utf-8") for path in chosen}
