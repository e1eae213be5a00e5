"""The numbers of an algorithm that the keypad sets, and their values at the ends of the ranges."""

from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

from heatwright.spec.commands import keypad_of
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import Interface
from heatwright.spec.quantity import number

COLUMNS = 16
"""Columns of the display: one line shows a number with its name and unit."""
MOST_DECIMALS = 4


class Kind(NamedTuple):
    """A kind of number that the keypad can set: its key in a spec, and its other names."""

    key: str
    field: str
    """The name of the number's field: in the algorithm, in its state and in the settings."""
    title: str
    """Text on the display before the number."""
    shown_unit: str
    """Text on the display after the number."""
    unit: str


KINDS = (
    Kind("hysteresis", "hysteresis_k", "Hysteresis ", "K", "K"),
    Kind("lead", "lead_s", "Lead ", " s", "s"),
    Kind("kp", "kp", "kp ", " %/K", "%/K"),
    Kind("ki", "ki", "ki ", " %/Ks", "%/(K*s)"),
    Kind("kd", "kd", "kd ", " %s/K", "%*s/K"),
)
GAINS = ("kp", "ki", "kd")


class Number(NamedTuple):
    """A number of one loop's algorithm, in its base unit."""

    kind: Kind
    value: float
    """The number's value in the spec."""
    minimum: float
    maximum: float
    step: float

    @property
    def decimals(self) -> int:
        """Fewest decimals that show each value the keypad can set; MOST_DECIMALS + 1 if none do."""
        reached = (self.value, self.minimum, self.maximum, self.step)
        able = (
            each
            for each in range(MOST_DECIMALS + 1)
            if all(round(value, each) == value for value in reached)
        )
        return next(able, MOST_DECIMALS + 1)

    def said(self, value: float) -> str:
        """Format a value as it is written in a spec: with its unit; gains have none."""
        return number(value) if self.kind.key in GAINS else f"{number(value)} {self.kind.unit}"

    def words(self, value: float) -> str:
        """Name the number with this value, for a message: `kp 2`."""
        return f"{self.kind.key} {self.said(value)}"


Setting = tuple[tuple[Number, float], ...]
"""The value of each number that the keypad sets."""


def numbers_of(controller: Controller, loop_name: str) -> tuple[Number, ...]:
    """List the numbers of a loop's algorithm that the keypad sets, in the order of the display."""
    keypad = keypad_of(controller)
    if keypad is None or keypad.adjust is None or keypad.loop != loop_name:
        return ()
    algorithm = controller.loops[loop_name].algorithm
    return tuple(
        Number(kind, getattr(algorithm, kind.field), each.minimum, each.maximum, each.step)
        for kind in KINDS
        if (each := getattr(keypad.adjust, kind.key)) and hasattr(algorithm, kind.field)
    )


def fixed(controller: Controller) -> tuple[Interface, ...]:
    """Return the interfaces, with a keypad that cannot set numbers: they keep the spec's values."""
    keypad = keypad_of(controller)
    return tuple(
        each.model_copy(update={"adjust": None}) if each is keypad else each
        for each in controller.interfaces
    )


def extremes(controller: Controller) -> Iterator[Setting]:
    """List all settings in which each number is at an end of its range; none without a keypad."""
    keypad = keypad_of(controller)
    if keypad is None or keypad.loop not in controller.loops:
        return
    numbers = numbers_of(controller, keypad.loop)
    ends = (((each, each.minimum), (each, each.maximum)) for each in numbers)
    yield from product(*ends) if numbers else ()


def with_setting(controller: Controller, setting: Setting) -> Controller:
    """Return the controller with a setting's numbers in its algorithm, no longer set by keys."""
    keypad = keypad_of(controller)
    if keypad is None or not setting:
        return controller
    loop = controller.loops[keypad.loop]
    values = {each.kind.field: value for each, value in setting}
    algorithm = loop.algorithm.model_copy(update=values)
    changed = controller.with_loop(keypad.loop, loop.model_copy(update={"algorithm": algorithm}))
    return changed.model_copy(update={"interfaces": fixed(controller)})


def words(setting: Setting) -> str:
    """Name the numbers of a setting with their values, for a message."""
    return ", ".join(each.words(value) for each, value in setting)
