"""The register map for the author of the master: Markdown, CSV, a Python client."""

from collections.abc import Iterable
from dataclasses import dataclass
from keyword import iskeyword

from heatwright.generator.plan.parts import File
from heatwright.generator.plan.registers import (
    NO_TEMPERATURE,
    VERSION,
    Kind,
    Register,
    RegisterMap,
    Table,
    register_map,
)
from heatwright.generator.plan.source import Source
from heatwright.generator.plan.text import markdown
from heatwright.spec import ModbusRtu
from heatwright.spec.quantity import number

TABLES: tuple[tuple[Table, str, str, str], ...] = (
    ("coils", "coil", "Coils", "1, 5, 15"),
    ("discretes", "discrete_input", "Discrete inputs", "2"),
    ("holdings", "holding_register", "Holding registers", "3, 6, 16, 22, 23"),
    ("inputs", "input_register", "Input registers", "4"),
)
READ_FUNCTIONS: dict[Table, str] = {
    "coils": "READ_COILS",
    "discretes": "READ_DISCRETE_INPUTS",
    "holdings": "READ_HOLDING_REGISTERS",
    "inputs": "READ_INPUT_REGISTERS",
}
FORMS: dict[Kind, str] = {"bit": "", "u16": "H", "i16": "h", "u32": "I", "f32": "f"}
"""The letter of Python's `struct` for each kind of register; none for a bit."""
SUFFIXES = {"°C": "_c", "%": "_percent", "A": "_a", "s": "_s", "K": "_k"}


@dataclass(frozen=True, slots=True)
class Row:
    """A row of a table for people, and of the CSV: a register, and its numbers as text."""

    register: Register
    addresses: str
    scale: str
    step: str
    minimum: str
    maximum: str
    range: str


@dataclass(frozen=True, slots=True)
class DocumentTable:
    """A table of the map: its name, its heading, and the functions that read and write it."""

    name: str
    title: str
    functions: str
    rows: list[Row]


@dataclass(frozen=True, slots=True)
class MapDocument:
    """The values for all documents of the map."""

    title: str
    name: str
    interface: ModbusRtu
    version: int
    digest: str
    tables: list[DocumentTable]


@dataclass(frozen=True, slots=True)
class Member:
    """A register as a member of a class of the client; order -- a coil without a state."""

    attribute: str
    address: int
    function: str
    kind: Kind
    form: str
    per_unit: int
    type: str
    access: str
    order: bool
    doc: str


@dataclass(frozen=True, slots=True)
class ClientPart:
    """A class of the client: a loop, or the machine."""

    attribute: str
    """Name of the machine's attribute that holds this part, if it is a loop."""
    title: str
    doc: str
    machine: bool
    registers: list[Member]


@dataclass(frozen=True, slots=True)
class Client:
    """Further values for the client's template."""

    machine: str
    no_temperature: int
    loops: list[ClientPart]
    parts: list[ClientPart]


def documents(source: Source, interface: ModbusRtu) -> Iterable[File]:
    """Plan registers.md, registers.csv and the client."""
    registers = register_map(source.spec)
    identity = source.controller.identity
    document = MapDocument(
        title=markdown(identity.title or identity.name),
        name=identity.name,
        interface=interface,
        version=VERSION,
        digest=registers.digest,
        tables=[
            DocumentTable(name, title, functions, [_row(each) for each in registers.table(table)])
            for table, name, title, functions in TABLES
        ],
    )
    yield File("registers.md", "interfaces/modbus_rtu/registers.md.j2", document)
    yield File("registers.csv", "interfaces/modbus_rtu/registers.csv.j2", document)
    yield File(
        f"client/{identity.name}_client.py",
        "interfaces/modbus_rtu/client.py.j2",
        (document, _client(source, registers)),
    )


def _row(register: Register) -> Row:
    last = register.address + register.words - 1
    ends = register.minimum, register.maximum
    least, most = ("" if end is None else number(end) for end in ends)
    unit = f" {register.unit}" if register.unit else ""
    return Row(
        register,
        addresses=f"{register.address}, {last}" if register.words > 1 else f"{register.address}",
        scale=f"{register.scale:g}",
        step="" if register.kind == "bit" else f"{register.scale:g}{unit}",
        minimum=least,
        maximum=most,
        range=f"{least} .. {most}{unit}" if least else "",
    )


def _client(source: Source, registers: RegisterMap) -> Client:
    own = [each for each in registers.registers if "." not in each.name]
    taken = {"check", *(_attribute(each) for each in own)}
    loops: list[ClientPart] = []
    for name in source.controller.loops:
        attribute = name
        while attribute in taken or iskeyword(attribute):
            attribute += "_loop"
        taken.add(attribute)
        members = [
            _member(each) for each in registers.registers if each.name.startswith(f"{name}.")
        ]
        title = f"{_title(attribute)}Loop"
        loops.append(
            ClientPart(attribute, title, f"Loop `{name}`.", machine=False, registers=members)
        )
    machine = ClientPart(
        attribute="",
        title=f"{_title(source.controller.identity.name)}Client",
        doc="The controller, with its loops.",
        machine=True,
        registers=[_member(each) for each in own],
    )
    return Client(machine.title, NO_TEMPERATURE, loops, [*loops, machine])


def _title(name: str) -> str:
    """Return a class name; it differs for different names, such as `hot_end` and `hotend`."""
    return "_".join(word.capitalize() for word in name.split("_"))


def _attribute(register: Register) -> str:
    return register.name.rpartition(".")[2] + SUFFIXES.get(register.unit, "")


def _member(register: Register) -> Member:
    unit = f" {register.unit}" if register.unit else ""
    within = (
        f" {number(register.minimum)} to {number(register.maximum)}{unit}."
        if register.minimum is not None and register.maximum is not None
        else f" In{unit}."
        if unit
        else ""
    )
    return Member(
        attribute=_attribute(register),
        address=register.address,
        function=READ_FUNCTIONS[register.table],
        kind=register.kind,
        form=FORMS[register.kind],
        per_unit=round(1 / register.scale),
        type=_type(register),
        access=register.access,
        order=register.table == "coils" and "." not in register.name,
        doc=register.meaning + within,
    )


def _type(register: Register) -> str:
    if register.kind == "bit":
        return "bool"
    if register.name.endswith(".temperature") or register.name.startswith("monitor_"):
        return "float | None"
    return "int" if register.kind != "f32" and register.scale == 1 else "float"
