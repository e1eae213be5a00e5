"""One processor in the shim, as its wrappers share it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

Range = tuple[int, int]
"""A run of RAM: first address, bytes."""


@dataclass(frozen=True)
class Hw:
    """The shim's functions, cffi, the processor (freed with its last user) and its clock.

    kept -- Python objects C points to.
    """

    lib: Any
    ffi: Any
    pointer: Any
    clock_hz: int
    kept: list[Any] = field(default_factory=list)
