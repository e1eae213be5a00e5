"""Places in the spec from which decisions come, as the generated code names them."""

from __future__ import annotations

from dataclasses import dataclass

from heatwright.generator.plan.numbers import c_count, c_float
from heatwright.generator.plan.parts import Constant
from heatwright.generator.plan.text import c_comment
from heatwright.spec import Controller, Spec


@dataclass(frozen=True, slots=True)
class Source:
    """One place in the spec; every constant made from it names file, line and key."""

    spec: Spec
    path: tuple[str | int, ...]

    @property
    def controller(self) -> Controller:
        """The whole controller, for a component that needs others."""
        return self.spec.controller

    def at(self, *path: str | int) -> Source:
        """Return the place below this one."""
        return Source(self.spec, (*self.path, *path))

    @property
    def where(self) -> str:
        """Such as `chamber.yaml:19 loops.air.period`; a key left out has its section's line."""
        keys = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in self.path)
        left_out = "" if self.path in self.spec.tree.positions else " (default)"
        return c_comment(f"{self.spec.file_name}:{self.spec.line(self.path)} {keys[1:]}{left_out}")

    def count(self, name: str, value: int, derivation: str) -> Constant:
        """An unsigned constant and how it was derived."""
        return Constant(name, c_count(value), f"{self.where}: {derivation}")

    def number(self, name: str, value: float, derivation: str) -> Constant:
        """A float constant and how it was derived."""
        return Constant(name, c_float(value), f"{self.where}: {derivation}")
