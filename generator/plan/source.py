"""Places in the spec (file, line, key) that the generated code names as origins of decisions."""

from __future__ import annotations

from dataclasses import dataclass

from heatwright.generator.plan.numbers import c_count, c_float, in_periods, quantity, steps, ticks
from heatwright.generator.plan.parts import Constant
from heatwright.generator.plan.text import c_comment
from heatwright.spec import Controller, Loop, Spec
from heatwright.spec.board.uart import baud_setting


@dataclass(frozen=True, slots=True)
class Named:
    """The name of a part, also in C, and its place in the spec."""

    name: str
    NAME: str
    where: str


@dataclass(frozen=True, slots=True)
class Source:
    """One place in the spec; every constant made from it names file, line and key."""

    spec: Spec
    path: tuple[str | int, ...]

    @property
    def controller(self) -> Controller:
        """The whole controller, for a component that needs other parts of it."""
        return self.spec.controller

    def at(self, *path: str | int) -> Source:
        """Return the place below this one."""
        return Source(self.spec, (*self.path, *path))

    @property
    def where(self) -> str:
        """The place as `chamber.yaml:19 loops.air.period`; a missing key has its section's line."""
        keys = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in self.path)
        left_out = "" if self.path in self.spec.tree.positions else " (default)"
        return c_comment(f"{self.spec.file_name}:{self.spec.line(self.path)} {keys[1:]}{left_out}")

    def named(self, name: str) -> Named:
        """Name the part at this place, for its templates."""
        return Named(name, name.upper(), self.where)

    def count(self, name: str, value: int, derivation: str) -> Constant:
        """An unsigned constant and how it was derived."""
        return Constant(name, c_count(value), f"{self.where}: {derivation}")

    def steps(self, name: str, duration_s: float, loop: Loop, more: str = "") -> Constant:
        """The control steps that a time lasts, and how they were counted."""
        return self.count(name, steps(duration_s, loop), in_periods(duration_s, loop) + more)

    def ticks(self, name: str, duration_s: float, more: str = "") -> Constant:
        """The ticks that a time lasts."""
        return self.count(name, ticks(duration_s), quantity(duration_s, "s") + more)

    def baud(self, name: str, baud: int) -> Constant:
        """The divisor of a serial port for a baud rate; its comment has the real baud rate."""
        setting = baud_setting(self.controller.board.clock_hz, baud)
        words = f"{baud} baud, really {setting.baud:.0f}"
        return self.at("baud").count(name, setting.divisor, words)

    def given(self, name: str, value: float, unit: str, more: str = "") -> Constant:
        """A float constant with the number that the spec gives; `more` is added to its comment."""
        return self.number(name, value, quantity(value, unit) + more)

    def number(self, name: str, value: float, derivation: str) -> Constant:
        """A float constant and how it was derived."""
        return Constant(name, c_float(value), f"{self.where}: {derivation}")
