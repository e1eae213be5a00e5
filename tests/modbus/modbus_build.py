"""What the fixture `built` makes."""

from collections.abc import Callable

from heatwright.sim.elf import Elf
from heatwright.spec import Controller

Built = tuple[Controller, Elf]
Build = Callable[..., Built]
"""An example's name and pairs of texts, the first to be replaced by the second."""
