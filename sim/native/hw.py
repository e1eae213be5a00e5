"""One processor in the shim, shared by its Python wrappers, and the logs that the shim fills."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Range = tuple[int, int]
"""A range of RAM: first address, number of bytes."""


@dataclass(frozen=True)
class Hw:
    """The shim's functions, cffi, the processor (freed with its last user) and its clock.

    kept -- Python objects that C points to; errors -- exceptions that chips in Python have raised.
    """

    lib: Any
    ffi: Any
    pointer: Any
    clock_hz: int
    kept: list[Any] = field(default_factory=list)
    errors: list[BaseException] = field(default_factory=list)


class Log:
    """One of the shim's logs; ``take`` returns the records since the last call."""

    def __init__(self, hw: Hw, number: int, dtype: np.dtype[Any]) -> None:
        self._hw = hw
        self._number = number
        self._dtype = dtype
        self._parts: list[NDArray[Any]] = []
        self._nothing = np.empty(0, dtype)
        self._nothing.flags.writeable = False

    def __len__(self) -> int:
        waiting = int(self._hw.lib.hw_log_count(self._hw.pointer, self._number))
        return waiting + sum(len(part) for part in self._parts)

    def drain(self) -> None:
        """Move the shim's records into Python."""
        lib, ffi, hw = self._hw.lib, self._hw.ffi, self._hw.pointer
        count = lib.hw_log_count(hw, self._number)
        if count:
            data = lib.hw_log_data(hw, self._number)
            raw = ffi.buffer(data, count * self._dtype.itemsize)
            self._parts.append(np.frombuffer(bytearray(raw), self._dtype))
            lib.hw_log_clear(hw, self._number)

    def take(self) -> NDArray[Any]:
        """Return the records that have come since the last call, in order of time."""
        self.drain()
        if not self._parts:  # the usual case on a bench
            return self._nothing
        parts, self._parts = self._parts, []
        if len(parts) == 1:
            return parts[0]
        # Without a type, numpy would remove the padding of the records.
        return np.concatenate(parts, dtype=self._dtype)
