"""One processor in the shim, shared by its Python wrappers."""

from dataclasses import dataclass, field
from typing import Any

Range = tuple[int, int]
"""A range of RAM: first address, number of bytes."""


@dataclass(frozen=True)
class Hw:
    """The shim's functions, cffi, the processor (freed with its last user) and its clock.

    kept -- Python objects that C points to.
    """

    lib: Any
    ffi: Any
    pointer: Any
    clock_hz: int
    kept: list[Any] = field(default_factory=list)
