"""One round of mb2hal's reads and writes, and their line: format, rate, time-out of answers."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import ceil, floor, log10

from heatwright.generator.plan.interfaces.modbus_rtu.silence import silence_s
from heatwright.generator.plan.linuxcnc.names import blocks, controller_name, loop_names
from heatwright.generator.plan.registers import Register, RegisterMap, Table, register_map
from heatwright.generator.plan.source import Source
from heatwright.spec import Controller, ModbusRtu

FUNCTIONS: dict[Table, str] = {
    "discretes": "fnct_02_read_discrete_inputs",
    "inputs": "fnct_04_read_input_registers",
    "coils": "fnct_05_write_single_coil",
    "holdings": "fnct_06_write_single_register",
}
READ_OF_THE_CONTROLLER = (
    "map_version", "digest", "fault", "fault_temperature", "fault_time", "uptime",
)  # fmt: skip
SHORT = {"setpoint_in_force": "in-force"}
"""Short forms of names that would be too long in HAL."""
FRAME_BYTES = 8
"""Length of each request, and of the answer to a write: address, function, 2 + 2 bytes, CRC."""
ANSWER_BYTES = 5
"""Length of the answer to a read, without its data: address, function, length, CRC."""


@dataclass(frozen=True, slots=True)
class Transaction:
    """One request: adjacent registers of one table.

    name -- the middle part of its pins' names, `CONTROLLER.name.PIN.bit` (or `.float` and `.int`).
    """

    name: str
    table: Table
    first: int
    pins: tuple[str, ...]
    where: str

    @property
    def function(self) -> str:
        """The Modbus function, in mb2hal's words."""
        return FUNCTIONS[self.table]

    @property
    def line_bytes(self) -> int:
        """Bytes of request and answer together."""
        if self.table in {"coils", "holdings"}:
            return 2 * FRAME_BYTES
        words = self.table == "inputs"
        data = 2 * len(self.pins) if words else ceil(len(self.pins) / 8)
        return FRAME_BYTES + ANSWER_BYTES + data


def transactions(source: Source) -> tuple[Transaction, ...]:
    """List one round: writes before reads.

    So OFF is written before the first read shows that the controller answers: the controller
    switches a loop on only after an OFF.
    """
    registers = register_map(source.spec)
    return (*_writings(source, registers), *_readings(source, registers))


def _readings(source: Source, registers: RegisterMap) -> Iterable[Transaction]:
    yield _request("in", _named(registers, "inputs", READ_OF_THE_CONTROLLER), source)
    yield _request("bits", _named(registers, "discretes", ("fault_latched",)), source)
    names = loop_names(source.controller)
    for loop, addresses in blocks(source.controller).items():
        where = Source(source.spec, ("loops", loop))
        inputs, bits = (
            [each for each in registers.table(table) if each.address in addresses]
            for table in ("inputs", "discretes")
        )
        yield _request(f"{names[loop]}-in", inputs, where)
        yield _request(f"{names[loop]}-bits", bits, where)


def _writings(source: Source, registers: RegisterMap) -> Iterable[Transaction]:
    yield _request("acknowledge", _named(registers, "coils", ("acknowledge",)), source)
    for loop, name in loop_names(source.controller).items():
        where = Source(source.spec, ("loops", loop))
        setpoint = _named(registers, "holdings", (f"{loop}.setpoint",))
        yield _request(f"{name}-setpoint", setpoint, where.at("setpoint"))
        yield _request(f"{name}-enabled", _named(registers, "coils", (f"{loop}.enabled",)), where)


def _named(registers: RegisterMap, table: Table, names: Sequence[str]) -> list[Register]:
    return [each for each in registers.table(table) if each.name in names]


def _request(name: str, registers: list[Register], source: Source) -> Transaction:
    pins = tuple(pin for each in registers for pin in _pins(each))
    return Transaction(name, registers[0].table, registers[0].address, pins, source.where)


def _pins(register: Register) -> tuple[str, ...]:
    last = register.name.rpartition(".")[2]
    name = SHORT.get(last, last.replace("_", "-"))
    return (name,) if register.words == 1 else (f"{name}-high", f"{name}-low")


ANSWER_S = 0.005
"""Longest time from the silence after a request to the slave's answer."""
MARGIN_S = 1.0
"""Margin for a PC without real time and a USB adapter that buffers. It is ample, because a late
answer is taken for the next request's: RTU frames have no numbers."""
FASTEST_HZ = 5.0
"""Highest rate of the rounds: a higher one is not visible on a panel."""
MOST_LOAD = 0.5
"""Largest share of the time for which the line may be busy."""
MOST_SILENCE = 0.25
"""Longest time between two rounds, as a share of the time after which the master is lost."""
HEARD_WITHIN_S = 5.0
"""Time after which the connection is lost, if the spec has no time for a lost master."""


@dataclass(frozen=True, slots=True)
class BusNames:
    """The values for mb2hal's configuration."""

    name: str
    where: str
    port: str
    interface: ModbusRtu
    delay_ms: int
    timeout_ms: int
    round: str
    rate: str
    transactions: tuple[Transaction, ...]


def bus_names(source: Source, interface: ModbusRtu) -> BusNames:
    """Compute the values for mb2hal's configuration."""
    round_ = transactions(source)
    return BusNames(
        name=controller_name(source.controller),
        where=source.where,
        port=port_name(source),
        interface=interface,
        delay_ms=ceil(1000 * silence_s(interface)),
        timeout_ms=ceil(1000 * answer_within_s(interface)),
        round=f"{round_s(interface, round_):.2g} s",
        rate=f"{rate_hz(source, interface):.2g}",
        transactions=round_,
    )


def port_name(source: Source) -> str:
    """Name of the link to the serial port that the user creates beside the configuration."""
    return f"{source.controller.identity.name}_port"


def round_s(interface: ModbusRtu, round_: tuple[Transaction, ...]) -> float:
    """Time for all transactions, one after the other, s."""
    line_s = sum(each.line_bytes for each in round_) * _character_s(interface)
    return line_s + len(round_) * (2 * silence_s(interface) + ANSWER_S)


def rate_hz(source: Source, interface: ModbusRtu) -> float:
    """Return the rate of the rounds, rounded down: FASTEST_HZ, or what MOST_LOAD allows if less.

    If the master would be lost at this rate, it is higher.
    """
    busy_s = round_s(interface, transactions(source))
    seldom_hz = 1 / (busy_s + MOST_SILENCE * lost_after_s(source.controller))
    hertz = min(FASTEST_HZ, max(MOST_LOAD / busy_s, seldom_hz))
    step = 10.0 ** (floor(log10(hertz)) - 1)
    return floor(hertz / step) * step


def lost_after_s(controller: Controller) -> float:
    """Shortest time without a request after which the master of a loop is lost, s."""
    times = [loop.protection.master_lost_after_s for loop in controller.loops.values()]
    return min((time for time in times if time is not None), default=HEARD_WITHIN_S)


def _character_s(interface: ModbusRtu) -> float:
    return interface.character_bits / interface.baud


def answer_within_s(interface: ModbusRtu) -> float:
    """Longest time from the end of mb2hal's write call to an answer's first byte, s."""
    longest_request = 8 * _character_s(interface)
    return longest_request + silence_s(interface) + ANSWER_S + MARGIN_S
