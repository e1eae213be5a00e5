"""Pin and serial activity as a Value Change Dump, for a waveform viewer such as GTKWave."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from numpy.typing import NDArray
from vcd import VCDWriter

from heatwright.sim.native.pins import Source, pin_number

_FLOATING = "z"


class VcdRecorder:
    """Writes a file while a device runs: ``with VcdRecorder(path, pins, clock_hz) as recorder``.

    pins -- the processor's pins by their names in the file; the time unit is 1 ns. A floating pin
    is written as z. The UARTs' output is written as bytes, at the time of their write to UDR.
    """

    def __init__(self, path: Path | str, pins: Mapping[str, str], clock_hz: int) -> None:
        self._file = Path(path).open("w", encoding="ascii")  # noqa: SIM115 - closed by close()
        self._writer = VCDWriter(self._file, timescale="1 ns", date="")
        self._ns = 1e9 / clock_hz
        self._pins = {
            pin_number(pin): self._writer.register_var("pins", name, "wire", 1, init=_FLOATING)
            for name, pin in pins.items()
        }
        self._uart = self._writer.register_var("serial", "tx", "reg", 8, init="x")

    def __enter__(self) -> VcdRecorder:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def feed(self, pins: NDArray[Any], sent: NDArray[Any]) -> None:
        """Process pin changes (PIN_EVENT) and bytes sent (UART_BYTE)."""
        changes: list[tuple[int, Any, Any]] = []
        for event in pins:
            variable = self._pins.get(int(event["pin"]))
            if variable is not None:
                changes.append((round(int(event["cycle"]) * self._ns), variable, _value(event)))
        for byte in sent:
            time = round(int(byte["written"]) * self._ns)
            changes.append((time, self._uart, int(byte["value"])))
        for time, variable, value in sorted(changes, key=lambda change: change[0]):
            self._writer.change(variable, time, value)

    def close(self) -> None:
        """End the file."""
        self._writer.close()
        self._file.close()


def _value(event: Any) -> Any:
    state = int(event["state"])
    return _FLOATING if state >> 1 == Source.FLOATING else state & 1
