"""A slave with the register map of the fabricator, made with pymodbus: no firmware, no machine.

It keeps the rules that the master side leans on: a loop is switched on only after it was off, and
never while a fault is latched; a fault is acknowledged by a change from 0 to 1.
"""

import asyncio
import os
import select
import threading
import time
import tty
from contextlib import suppress
from pathlib import Path
from types import TracebackType

from pymodbus.constants import ExcCodes
from pymodbus.framer import FramerType
from pymodbus.server import ModbusSerialServer
from pymodbus.simulator import DataType, SimData, SimDevice

FABRICATOR = Path(__file__).parents[2] / "spec" / "examples" / "fabricator.yaml"
READ_DISCRETES, READ_INPUTS, WRITE_COIL, WRITE_HOLDING = 2, 4, 5, 6
UPTIME_LOW = 8
LOOP = 100


class MadeUpBoard:
    """Answers at `port`; a context manager."""

    def __init__(self, digest: int) -> None:
        self.digest = digest
        self.fault = 0
        self.fault_celsius = 0.0
        self.celsius = 21.5
        self.duty_percent = 12.3
        self.amperes = 1.78
        self.setpoint_celsius = 30.0
        self.enabled = False
        self.released = False
        self.deaf = False
        self.slow_s = 0.0
        """How long after it was switched on it reports WORK."""
        self.refused: list[tuple[int, int, int]] = []
        """Writes that were answered with an exception: function, address, value."""
        self.acknowledged = 0
        self._reset = 0
        self._start = self._enabled_at = time.monotonic()
        self._board_end, board = _terminal()
        self._master_end, self._master = _terminal()
        self._board = board
        self.port = os.ttyname(self._master)
        os.chmod(self.port, 0o666)  # noqa: PTH101, S103 - mb2hal runs as another user
        self._loop = asyncio.new_event_loop()
        self._served, self._over = threading.Event(), threading.Event()

    def __enter__(self) -> "MadeUpBoard":
        self._threads = [threading.Thread(target=target) for target in (self._carry, self._serve)]
        for thread in self._threads:
            thread.start()
        assert self._served.wait(10)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        asyncio.run_coroutine_threadsafe(self._server.shutdown(), self._loop).result(10)
        self._over.set()
        for thread in self._threads:
            thread.join(10)
        for end in (self._board_end, self._board, self._master_end, self._master):
            os.close(end)

    def restart(self) -> None:
        """Lose the power for a moment."""
        self._start = time.monotonic()
        self.enabled = self.released = False

    def trip(self, code: int, celsius: float) -> None:
        self.fault, self.fault_celsius = code, celsius
        self.enabled = self.released = False

    async def _answer(  # noqa: PLR0917 - pymodbus's own
        self, function: int, start: int, address: int, count: int,
        registers: list[int], values: list[int] | list[bool] | None,
    ) -> ExcCodes | None:  # fmt: skip
        del start, count
        if self.deaf:
            return ExcCodes.DEVICE_BUSY
        if values is not None:
            return self._written(function, address, int(values[0]))
        if function == READ_INPUTS:
            self._show(registers)
        elif function == READ_DISCRETES:
            registers[0] = int(self.fault > 0)
            registers[LOOP // 16] = sum(
                bit << (LOOP % 16 + n) for n, bit in enumerate(self._bits())
            )
        return None

    def _show(self, registers: list[int]) -> None:
        uptime_s = int(time.monotonic() - self._start)
        registers[: UPTIME_LOW + 1] = [
            1, self.digest >> 16, self.digest & 0xFFFF,
            self.fault, _tenths(self.fault_celsius), 0, 0, 0, uptime_s & 0xFFFF,
        ]  # fmt: skip
        registers[LOOP : LOOP + 6] = [
            _tenths(self.celsius), round(10 * self.duty_percent), _tenths(self.setpoint_celsius),
            0, 0, round(100 * self.amperes),
        ]  # fmt: skip

    def _bits(self) -> list[bool]:
        works = self.enabled and time.monotonic() - self._enabled_at >= self.slow_s
        near = abs(self.celsius - self.setpoint_celsius) <= 2
        return [
            works,
            works and self.celsius < self.setpoint_celsius - 2,
            works and self.celsius > self.setpoint_celsius + 2,
            works and near,
            True,
        ]

    def _written(self, function: int, address: int, value: int) -> ExcCodes | None:
        if function == WRITE_HOLDING and address == LOOP:
            celsius = (value - 0x10000 if value > 0x7FFF else value) / 10
            good = 0 <= celsius <= 320
            self.setpoint_celsius = celsius if good else self.setpoint_celsius
        elif function == WRITE_COIL and address == LOOP:
            good = not value or self.enabled or (self.released and not self.fault)
            self.released = self.released or not value
            if value and good and not self.enabled:
                self._enabled_at = time.monotonic()
            self.enabled = bool(value) and good
        elif function == WRITE_COIL and address == 0:
            good = True
            if value > self._reset and self.fault:
                self.fault, self.acknowledged = 0, self.acknowledged + 1
            self._reset = value
        else:
            return ExcCodes.ILLEGAL_ADDRESS
        if good:
            return None
        self.refused.append((function, address, value))
        return ExcCodes.ILLEGAL_VALUE

    def _carry(self) -> None:
        """Move the bytes between the pseudo-terminals: pymodbus opens one, the master the other."""
        across = {self._board_end: self._master_end, self._master_end: self._board_end}
        while not self._over.is_set():
            ready, _, _ = select.select(list(across), [], [], 0.1)
            for end in ready:
                os.write(across[end], os.read(end, 256))

    def _serve(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.run_until_complete(self._until_shut_down())

    async def _until_shut_down(self) -> None:
        bits, words = DataType.BITS, DataType.REGISTERS
        device = SimDevice(
            id=1,
            simdata=(
                [SimData(0, values=[False] * 128, datatype=bits)],
                [SimData(0, values=[False] * 128, datatype=bits)],
                [SimData(LOOP, values=[300], datatype=words)],
                [
                    SimData(0, values=[0] * 16, datatype=words),
                    SimData(LOOP, values=[0] * 6, datatype=words),
                ],
            ),
            action=self._answer,
        )
        self._server = ModbusSerialServer(
            device, framer=FramerType.RTU, port=os.ttyname(self._board), baudrate=19_200
        )
        self._served.set()
        with suppress(asyncio.CancelledError):
            await self._server.serve_forever()


def _terminal() -> tuple[int, int]:
    near, far = os.openpty()
    tty.setraw(far)
    return near, far


def _tenths(celsius: float) -> int:
    return round(10 * celsius) & 0xFFFF
