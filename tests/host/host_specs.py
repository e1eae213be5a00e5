"""Specifications that, between them, take every branch of the templates, and their host builds. A
build is made once (`build/rig`), by all that goes into it."""

import hashlib
from collections.abc import Callable, Mapping
from copy import deepcopy
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import yaml
from rig.firmware import changed, flow, kept, put

from heatwright.generator import plan_firmware, render, write
from heatwright.sim.host import Host, HostBuild, build_host
from heatwright.sim.host import __file__ as package
from heatwright.sim.host.parts import parts_of
from heatwright.spec import Spec, load_text

_FAMILIES = yaml.load(
    Path(__file__).with_suffix(".yaml").read_text(encoding="utf-8"),
    yaml.BaseLoader,  # noqa: S506 - everything is text: "off" is a word of the language
)
NOTHING = "null"
_EXAMPLES = ("extruder", "feeder")


def _text(*changes: dict[str, Any]) -> str:
    spec: dict[str, Any] = {}
    for change in changes:
        for path, value in change.items():
            put(spec, path, None if value == NOTHING else deepcopy(value))
    return "".join(f"{key}: {flow(value)}\n" for key, value in spec.items() if value)


def _family(name: str) -> dict[str, str]:
    base, *variants = _FAMILIES[name].items()
    return {each: _text(_FAMILIES["all"], base[1], change) for each, change in variants}


_COMMANDED = _family("commanded") | {name: changed(name) for name in _EXAMPLES}
_SWITCHED, _PROGRAMMED = _family("switched"), _family("programmed")
_PLAIN = _family("plain")
TEXTS = _PLAIN | _COMMANDED | _SWITCHED | _PROGRAMMED
NAMES = tuple(TEXTS)
SEVERAL = {
    "printer": changed("printer"),
    "both heaters on one timer": changed("printer")
    .replace("pin: D10, frequency: 30 Hz", "pin: D22, frequency: 30 Hz")
    .replace("pin: D8, frequency: 30 Hz", "pin: D23, frequency: 20 Hz"),
    "barrel": changed("barrel"),
}
"""Specs with two loops."""
HOSTED = (*_COMMANDED, "held_by_host")
PROGRAMMED = tuple(name for name, text in _PROGRAMMED.items() if "programs:" in text)
BY_MASTER = tuple(name for name, text in _SWITCHED.items() if "modbus" in text)
BY_KEYS = tuple(name for name, text in _PLAIN.items() if "lcd_keypad" in text)
SWITCHED = (*BY_MASTER, *BY_KEYS, *_PROGRAMMED)
COMMANDED = (*HOSTED, *SWITCHED)
SWITCHING = tuple(_SWITCHED)


def in_other_order(text: str) -> str:
    spec = yaml.load(text, yaml.BaseLoader)  # noqa: S506 - everything is text
    return _text({**spec, "loops": dict(reversed(spec["loops"].items()))})


@cache
def spec_of(name: str) -> Spec:
    return load_text(TEXTS[name], f"{name}.yaml")


@cache
def build_of_spec(spec: Spec, *, sanitized: bool = True) -> HostBuild:
    """Return the build of any specification.

    spec -- the specification; sanitized -- else without gcc's sanitizer, which would end the
    process at a mutant's first overflow.
    """
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
    folder = Path(package).parent
    return b"".join(
        path.read_bytes() for path in sorted(folder.rglob("*.[chp]*")) if path.is_file()
    )


def sources_of(build: HostBuild) -> Mapping[str, str]:
    source = build.project / "src"
    chosen = [
        path for path in source.iterdir() if path.suffix == ".h" or path.name in build.objects
    ]
    return {path.name: path.read_text(encoding="utf-8") for path in chosen}


class BuildArena:
    """An arena of the mutation engine: all mutants of a host build are one library."""

    together = True

    def __init__(self, name: str, spec: Callable[[], Spec]) -> None:
        self.name, self._spec = name, spec

    @property
    def built(self) -> HostBuild:
        return build_of_spec(self._spec(), sanitized=False)

    def headers(self) -> Mapping[str, str]:
        return sources_of(self.built)

    def build(self, changed: Mapping[str, str], folder: Path) -> Path:
        built = self.built
        for name, text in changed.items():
            built = built.with_changed(name, text, folder)
        return built.library

    def host(self, library: Path) -> Host:
        return Host(replace(self.built, library=library))
