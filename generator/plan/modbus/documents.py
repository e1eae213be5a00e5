"""The register map for those who write the master: Markdown, CSV, a Python client."""

from __future__ import annotations

from collections.abc import Iterable
from keyword import iskeyword
from typing import Any

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
"""Letters of Python's `struct`."""
SUFFIXES = {"°C": "_c", "%": "_percent", "A": "_a", "s": "_s", "K": "_k"}
PARITIES = {"even": "E", "odd": "O", "none": "N"}


def documents(source: Source, interface: ModbusRtu) -> Iterable[File]:
    """Plan registers.md, registers.csv and the client."""
    registers = register_map(source.spec)
    identity = source.controller.identity
    context = {
        "title": markdown(identity.title or identity.name),
        "name": identity.name,
        "address": interface.address,
        "form": f"{interface.baud} baud, 8{PARITIES[interface.parity]}{interface.stop_bits}",
        "baud": interface.baud,
        "parity": PARITIES[interface.parity],
        "stop_bits": interface.stop_bits,
        "version": VERSION,
        "digest": registers.digest,
        "tables": [_table(registers, *each) for each in TABLES],
    }
    yield File("registers.md", "interfaces/modbus_rtu/registers.md.j2", context)
    yield File("registers.csv", "interfaces/modbus_rtu/registers.csv.j2", context)
    yield File(
        f"client/{identity.name}_client.py",
        "interfaces/modbus_rtu/client.py.j2",
        context | _client(source, registers),
    )


def _table(
    registers: RegisterMap, table: Table, name: str, title: str, functions: str
) -> dict[str, Any]:
    return {
        "name": name,
        "title": title,
        "functions": functions,
        "rows": [_row(each) for each in registers.table(table)],
    }


def _row(register: Register) -> dict[str, Any]:
    last = register.address + register.words - 1
    ends = [_end(register.minimum), _end(register.maximum)]
    unit = f" {register.unit}" if register.unit else ""
    return {
        "address": register.address,
        "addresses": f"{register.address}, {last}" if register.words > 1 else register.address,
        "words": register.words,
        "name": register.name,
        "kind": register.kind,
        "scale": f"{register.scale:g}",
        "step": "" if register.kind == "bit" else f"{register.scale:g}{unit}",
        "unit": register.unit,
        "minimum": ends[0],
        "maximum": ends[1],
        "range": f"{ends[0]} .. {ends[1]}{unit}" if ends[0] else "",
        "access": register.access,
        "meaning": register.meaning,
    }


def _end(value: float | None) -> str:
    return "" if value is None else number(value)


def _client(source: Source, registers: RegisterMap) -> dict[str, Any]:
    own = [each for each in registers.registers if "." not in each.name]
    taken = {"check", *(_attribute(each) for each in own)}
    loops: list[dict[str, Any]] = []
    for name in source.controller.loops:
        attribute = name
        while attribute in taken or iskeyword(attribute):
            attribute += "_loop"
        taken.add(attribute)
        loops.append(
            {
                "attribute": attribute,
                "title": f"{_title(attribute)}Loop",
                "doc": f"Loop `{name}`.",
                "machine": False,
                "registers": [
                    _member(each)
                    for each in registers.registers
                    if each.name.startswith(f"{name}.")
                ],
            }
        )
    name = source.controller.identity.name
    machine = {
        "title": f"{_title(name)}Client",
        "doc": "The controller, with its loops.",
        "machine": True,
        "registers": [_member(each) for each in own],
    }
    return {
        "machine": machine["title"],
        "no_temperature": NO_TEMPERATURE,
        "loops": loops,
        "parts": [*loops, machine],
    }


def _title(name: str) -> str:
    """A class of its own for each name: `hot_end` and `hotend` are two."""
    return "_".join(word.capitalize() for word in name.split("_"))


def _attribute(register: Register) -> str:
    return register.name.rpartition(".")[2] + SUFFIXES.get(register.unit, "")


def _member(register: Register) -> dict[str, Any]:
    unit = f" {register.unit}" if register.unit else ""
    within = (
        f" {number(register.minimum)} to {number(register.maximum)}{unit}."
        if register.minimum is not None and register.maximum is not None
        else f" In{unit}."
        if unit
        else ""
    )
    return {
        "attribute": _attribute(register),
        "address": register.address,
        "function": READ_FUNCTIONS[register.table],
        "kind": register.kind,
        "form": FORMS[register.kind],
        "per_unit": round(1 / register.scale),
        "type": _type(register),
        "access": register.access,
        "order": register.table == "coils" and "." not in register.name,
        "doc": register.meaning + within,
    }


def _type(register: Register) -> str:
    if register.kind == "bit":
        return "bool"
    if register.name.endswith(".temperature") or register.name.startswith("monitor_"):
        return "float | None"
    return "int" if register.kind != "f32" and register.scale == 1 else "float"
