"""The reads and writes of mb2hal in one round."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import ceil

from heatwright.generator.plan.linuxcnc.names import blocks, loop_names
from heatwright.generator.plan.registers import Register, RegisterMap, Table, register_map
from heatwright.generator.plan.source import Source

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
