"""A slave with the register map of the fabricator behind a pseudo-terminal: no firmware, no plant.

What it answers the Modbus tests' oracle says, which was written from the documents, and keeps the
rules that the master side leans on: a loop is switched on only after it was off, and never while a
fault is latched; a fault is acknowledged by a change from 0 to 1.
"""

import os
import select
import threading
import time
import tty

from rig.modbus_oracle import Oracle
from rig.specs import controller_of

from heatwright.sim.interfaces.modbus_frames import EXCEPTION, framed

FABRICATOR = "fabricator"
REQUEST_BYTES = 8
"""Of everything that mb2hal sends: it reads, and writes one value at a time."""
BUSY = 6
WRITES = (5, 6)
WORK, HEAT, COOL, WARM = 1, 2, 4, 8
DEAD_BAND_K = 2


class MadeUpBoard:
    """Answers at `port`; a context manager."""

    def __init__(self) -> None:
        self.oracle = Oracle(controller_of(FABRICATOR))
        self.nozzle = self.oracle.loops["nozzle"]
        self.celsius, self.duty_percent, self.amperes = 21.5, 12.3, 1.78
        self.has_measured, self.deaf = True, False
        self.slow_s = 0.0
        """How long after it was switched on it reports WORK."""
        self.refused: set[int] = set()
        """Values of writes that were answered with an exception."""
        self._end, self._master = os.openpty()
        tty.setraw(self._master)
        self.port = os.ttyname(self._master)
        os.chmod(self.port, 0o666)  # noqa: PTH101, S103 - mb2hal runs as another user
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._serve)
        self.restart()
        self._enabled_at = self._start

    def __enter__(self) -> "MadeUpBoard":
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._over.set()
        self._thread.join(10)
        os.close(self._end)
        os.close(self._master)

    @property
    def enabled(self) -> bool:
        return self.nozzle.enabled

    @property
    def setpoint_celsius(self) -> float:
        return round(self.nozzle.setpoint, 4)

    def restart(self) -> None:
        """Lose the power for a moment."""
        self._start = time.monotonic()
        self.nozzle.enabled = self.nozzle.released = False

    def trip(self, code: int, celsius: float) -> None:
        self.oracle.fault, self.oracle.world["fault_temperature"] = code, celsius
        self.nozzle.enabled = self.nozzle.released = False

    def turn_digest(self, bits: int) -> None:
        """Be the firmware of another spec: turn some bits of the digest."""
        self.oracle.digest = f"{int(self.oracle.digest, 16) ^ bits:08x}"

    def _serve(self) -> None:
        data = b""
        while not self._over.is_set():
            ready, _, _ = select.select([self._end], [], [], 0.1)
            data = data + os.read(self._end, 256) if ready else b""
            if len(data) >= REQUEST_BYTES:
                os.write(self._end, self._answer(data))
                data = b""

    def _answer(self, request: bytes) -> bytes:
        if self.deaf:
            return framed(request[0], bytes([request[1] | EXCEPTION, BUSY]))
        was_enabled = self.enabled
        self.oracle.world |= self._world()
        answer = self.oracle.hear(request)
        if self.enabled and not was_enabled:
            self._enabled_at = time.monotonic()
        if request[1] in WRITES and answer[1:2] == bytes([request[1] | EXCEPTION]):
            self.refused.add(int.from_bytes(request[4:6], "big"))
        return answer

    def _world(self) -> dict[str, float]:
        works = self.enabled and time.monotonic() - self._enabled_at >= self.slow_s
        above_k = self.celsius - self.nozzle.setpoint
        state = HEAT if above_k < -DEAD_BAND_K else COOL if above_k > DEAD_BAND_K else WARM
        return {
            "uptime": int(time.monotonic() - self._start),
            "nozzle.has_reading": self.has_measured, "nozzle.temperature": self.celsius,
            "nozzle.duty": self.duty_percent, "nozzle.setpoint_in_force": self.nozzle.setpoint,
            "nozzle.current": self.amperes, "nozzle.states": (WORK | state) * works,
        }  # fmt: skip
