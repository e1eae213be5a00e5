"""Specs of the tests and what is generated from them, each read and generated once."""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType

from heatwright.generator import plan_firmware, render
from heatwright.spec import Controller, Spec, load, load_text

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "spec" / "examples"
EXAMPLE_NAMES = sorted(path.stem for path in EXAMPLES.glob("*.yaml"))


@cache
def example(name: str) -> Spec:
    return load(EXAMPLES / f"{name}.yaml")


@cache
def spec_of(text: str) -> Spec:
    return load_text(text, "spec.yaml")


def controller_of(spec: str) -> Controller:
    return (spec_of(spec) if "\n" in spec else example(spec)).controller


@cache
def files_of(spec: str) -> Mapping[str, str]:
    """Generate the project of a spec's text, or of the example of that name: path and text."""
    found = spec_of(spec) if "\n" in spec else example(spec)
    return MappingProxyType(dict(render(plan_firmware(found))))


def sources_of(spec: str) -> dict[str, str]:
    """Return what is in the project's `src/`, by its name there."""
    files = files_of(spec)
    return {path.removeprefix("src/"): files[path] for path in files if path.startswith("src/")}


def changed(spec: str, *changes: tuple[str, str]) -> str:
    """Return a spec's text, or that of the example of that name, with parts of it replaced."""
    text = spec if "\n" in spec else (EXAMPLES / f"{spec}.yaml").read_text("utf-8")
    for old, new in changes:
        assert text.count(old) == 1, f"it stands there {text.count(old)} times: {old}"
        text = text.replace(old, new)
    return text
