"""A Modbus master: it polls and writes, and checks the slave's answers."""

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from heatwright.sim.avr import Avr
from heatwright.sim.interfaces.look import Look
from heatwright.sim.interfaces.modbus_rtu import frames, registers
from heatwright.sim.interfaces.modbus_rtu.bus import Bus, Frame
from heatwright.sim.interfaces.modbus_rtu.frames import TO_ALL, Exchange
from heatwright.sim.interfaces.modbus_rtu.registers import Register
from heatwright.sim.native.characters import Format
from heatwright.sim.native.pins import pin_number
from heatwright.spec import Board, Controller
from heatwright.spec import ModbusRtu as Spec
from heatwright.spec.interfaces import Line

POLL_S = 1.0
"""How often the master polls, s; the firmware treats it as lost after several seconds."""
ANSWER_S = 0.2
"""Longest time from the silence that ends a request to the first byte of its answer, s."""
TURNAROUND_S = 0.1
"""Pause after a broadcast (serial line 1.02, 2.4.1: 100 to 200 ms)."""
LOOK_S = 0.002
"""How often it checks whether an answer has ended, s."""
SENDS = 3
"""How often an unanswered write is sent."""
NOT_NOW = 3
"""The exception code of a value that is not allowed at present."""


@dataclass(frozen=True)
class Refusal:
    """A write that the slave has refused or, with exception 0, never answered."""

    time_s: float
    name: str
    exception: int


class ModbusMaster:
    """The master of a simulated board.

    values -- the values last read, by name; refusals -- failed writes; polls -- number of answered
    polls; unanswered -- number of requests without an answer, repeats included; strangers -- frames
    without a request; damaged -- answers with a wrong CRC, parity or stop bit; slowest_s -- longest
    time from the silence that ends a request to its answer; longest_gap_s -- longest gap in an
    answer; bus -- the line; is_plugged -- whether it is plugged in.
    """

    complaints: tuple[str, ...] = ()

    def __init__(self, avr: Avr, bus: Bus, address: int) -> None:
        """Create the master of one slave; it polls once it knows the slave's registers."""
        self.bus = bus
        self.address = address
        self.values: dict[str, float] = {}
        self.refusals: list[Refusal] = []
        self.polls = self.unanswered = self.strangers = self.damaged = 0
        self.slowest_s = self.longest_gap_s = 0.0
        self._avr = avr
        self._registers: Mapping[str, Register] = {}
        self._blocks: list[tuple[int, list[Register]]] = []
        self._queue: deque[Exchange] = deque()
        self._current: Exchange | None = None
        self.is_plugged = True
        self._poll_s = POLL_S
        self._free_s = 0.0

    # -- operation -----------------------------------------------------------------------------

    def learn(self, controller: Controller) -> None:
        """Learn the registers of a controller, its slave."""
        self.serve(registers.registers(controller))

    def serve(self, known: Mapping[str, Register]) -> None:
        """Learn the slave's registers; poll its input registers from now on."""
        self._registers = known
        blocks: dict[int, list[Register]] = {}
        for register in known.values():
            if register.table == "input_register":
                blocks.setdefault(register.address // 100, []).append(register)
        self._blocks = [(block[0].address, block) for block in blocks.values()]

    def write(self, name: str, value: float | bool) -> None:
        """Write a value by its name in a scenario: °C, %, a gain, or a switch's state.

        If a loop refuses to be switched on because it needs a change from off to on, it is
        switched off and on. A command's bit is cleared, set and cleared, because the slave acts on
        the change, and after a reset has seen none. Raises LookupError: the slave has no such
        name.
        """
        if name not in self._registers:
            raise LookupError(f"The slave has no {name}: it has {', '.join(self._registers)}.")
        if "." in name:
            self._put(self.request(name, value))
            return
        for state in (False, value, False):
            self._put(self.request(name, state))

    def request(self, name: str, value: float | bool) -> Exchange:
        """Return the request that writes a value."""
        register = self._registers[name]
        if register.kind == "bit":
            pdu = frames.write_coil(register.address, on=bool(value))
        elif register.words == 1:
            pdu = frames.write_register(register.address, register.raw(value)[0])
        else:
            pdu = frames.write_registers(register.address, register.raw(value))
        return Exchange(self.address, pdu, name, SENDS)

    def ask(self, pdu: bytes, address: int | None = None) -> Exchange:
        """Send any request once; the returned exchange gets its result while the board runs."""
        exchange = Exchange(self.address if address is None else address, pdu)
        self._put(exchange)
        return exchange

    @property
    def is_busy(self) -> bool:
        """Whether a user's request is still under way."""
        current = self._current is not None and not self._current.polls
        return current or any(not each.polls for each in self._queue)

    @property
    def fault(self) -> int:
        """The latched fault as last read from the slave; 0: none, or not read yet."""
        return int(self.values.get("fault", 0))

    def unplug(self) -> None:
        """Unplug the master: it sends and receives nothing more."""
        self.is_plugged = False
        self._queue.clear()
        self._current = None

    def plug(self) -> None:
        """Plug the master in again."""
        self.is_plugged = True
        self._poll_s = self._free_s = self._avr.time_s

    # -- time ----------------------------------------------------------------------------------

    @property
    def wake_cycle(self) -> int | None:
        """The cycle of the master's next action; None: there is none."""
        if not self.is_plugged:
            return None
        now_s = self._avr.time_s
        if self._current is not None:
            wake_s = now_s + LOOK_S
        elif self._queue:
            wake_s = self._free_s
        elif self._blocks:
            wake_s = max(self._poll_s, self._free_s)
        else:
            return None
        return max(round(wake_s * self._avr.clock_hz), self._avr.cycle + 1)

    @property
    def look(self) -> Look | None:
        """How C may look for an answer of which no byte has come yet."""
        waits, at = self._current, self.wake_cycle
        if waits is None or at is None or self.bus.has_heard:
            return None
        latest_s = waits.sent_s or 0.0
        if waits.address != TO_ALL:
            latest_s += self.bus.silence_s + ANSWER_S
        clock_hz = self._avr.clock_hz
        latest, silence = (
            max(1, math.floor(each * clock_hz) - 1) for each in (latest_s, self.bus.silence_s)
        )
        every = round(LOOK_S * clock_hz)
        return Look(at, every, latest, drifts=True, uart=self.bus.uart, silence=silence)

    def feed(self, pins: NDArray[Any], sent: NDArray[Any]) -> None:
        """Receive the bytes from the board, and continue the exchange."""
        for frame in self.bus.feed(pins, sent):
            if self.is_plugged:
                self._hear(frame)
        if self.is_plugged:
            self._go_on(self._avr.time_s)

    def _put(self, exchange: Exchange) -> None:
        if not self.is_plugged:
            return
        self._queue.append(exchange)
        self._go_on(self._avr.time_s)

    def _go_on(self, now_s: float) -> None:
        if self._current is not None:
            self._wait(self._current, now_s)
        if self._current is not None or now_s < self._free_s:
            return
        if not self._queue and self._blocks and now_s >= self._poll_s:
            self._poll_s = max(self._poll_s + POLL_S, now_s)
            self._queue.extend(self._polls())
        if self._queue:
            self._send(self._queue.popleft())

    def _polls(self) -> list[Exchange]:
        return [
            Exchange(
                self.address,
                frames.read(4, first, max(each.address + each.words for each in block) - first),
                polls=True,
            )
            for first, block in self._blocks
        ]

    def _send(self, exchange: Exchange) -> None:
        exchange.sends -= 1
        exchange.sent_s = self.bus.send(frames.framed(exchange.address, exchange.pdu))
        self._current = exchange

    def _wait(self, exchange: Exchange, now_s: float) -> None:
        """Give up a request without an answer; a broadcast has none."""
        sent_s = exchange.sent_s or 0.0
        if exchange.address == TO_ALL:
            if now_s >= sent_s:
                self._free_s = sent_s + TURNAROUND_S
                self._end(exchange)
        elif not self.bus.hears and now_s >= sent_s + self.bus.silence_s + ANSWER_S:
            self.unanswered += 1
            self._free_s = now_s
            if exchange.sends:
                self._queue.appendleft(exchange)
                self._current = None
            else:
                self._end(exchange)

    # -- answers -------------------------------------------------------------------------------

    def _hear(self, frame: Frame) -> None:
        self._free_s = frame.end_s + self.bus.silence_s
        exchange = self._current
        if exchange is None or exchange.sent_s is None or frame.start_s < exchange.sent_s:
            self.strangers += 1
            return
        answer = frames.answer_to(exchange.address, exchange.pdu, frame.data)
        if answer is None or not frame.whole:
            self.damaged += 1
            return
        exchange.answer = answer
        exchange.delay_s = frame.start_s - exchange.sent_s - self.bus.silence_s
        self.slowest_s = max(self.slowest_s, exchange.delay_s)
        self.longest_gap_s = max(self.longest_gap_s, frame.longest_gap_s)
        self._end(exchange)

    def _end(self, exchange: Exchange) -> None:
        exchange.done = True
        self._current = None
        if exchange.polls:
            self._note(exchange)
        elif exchange.writes and exchange.address != TO_ALL:
            self._check(exchange)

    def _note(self, exchange: Exchange) -> None:
        if exchange.answer is None or exchange.refusal:
            return
        self.polls += 1
        words = exchange.answer.words()
        first = int.from_bytes(exchange.pdu[1:3], "big")
        block = next(block for start, block in self._blocks if start == first)
        for register in block:
            at = register.address - first
            self.values[register.name] = register.value(words[at : at + register.words])

    def _check(self, exchange: Exchange) -> None:
        """If a loop refuses to be switched on, try once more with a change from off to on."""
        if exchange.answer is not None and not exchange.refusal:
            return
        name = exchange.writes
        if exchange.refusal == NOT_NOW and name.endswith(".enabled") and not exchange.again:
            on, off = self.request(name, value=True), self.request(name, value=False)
            on.again = off.again = True
            self._queue.extendleft((on, off))
        else:
            self.refusals.append(Refusal(self._avr.time_s, name, exchange.refusal))


def format_of(line: Line | Spec) -> Format:
    """Return the format of a character on a line."""
    return Format(8, line.parity, line.stop_bits)


def attach(avr: Avr, board: Board, interface: Spec) -> ModbusMaster:
    """Connect the master to the board's first UART, and to its driver's pin."""
    driver = None
    if interface.driver_enable is not None:
        name = board.pins[interface.driver_enable].port_name
        driver = pin_number(name)
        avr.pins.pull(name, "low")
        avr.pins.watch(name)
    bus = Bus(avr, board.uarts[0].number, interface.baud, format_of(interface), driver)
    return ModbusMaster(avr, bus, interface.address)
