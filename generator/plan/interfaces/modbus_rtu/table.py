"""The register map in the C of the firmware."""

from dataclasses import dataclass

from heatwright.generator.plan.core import lockout_ends
from heatwright.generator.plan.loop.names import prefix_of
from heatwright.generator.plan.parts import Header
from heatwright.generator.plan.registers import (
    BLOCK,
    STATE_FAULT,
    STATE_VALID,
    TABLES,
    Register,
    Table,
    register_map,
)
from heatwright.generator.plan.source import Source
from heatwright.spec import facts_of


@dataclass(frozen=True, slots=True)
class Row:
    """A row of the C table: address, how, of -- C of a `struct map_entry`; what -- its comment."""

    address: int
    how: str
    of: str
    what: str


@dataclass(frozen=True, slots=True)
class MapTable:
    """A table of the map."""

    name: Table
    rows: list[Row]


@dataclass(frozen=True, slots=True)
class MapLoop:
    """A loop in the map."""

    name: str
    prefix: str
    block: int
    """First address of its registers."""
    tunable: bool
    cycles: int | None
    """Default number of cycles of a tuning; None without one."""
    cycles_where: str


@dataclass(frozen=True, slots=True)
class MapNames:
    """The values for the templates of the map."""

    where: str
    lockout: str
    block: int
    tables: list[MapTable]
    sizes: dict[Table, int]
    loops: list[MapLoop]
    monitors: list[str]
    gains: bool
    state_fault: int
    state_valid: int
    headers: list[Header]


def map_names(source: Source) -> MapNames:
    """Compute the values for the templates of the map."""
    registers, controller = register_map(source.spec), source.controller
    tables = [
        MapTable(name, [row for each in registers.table(name) for row in _rows(each)])
        for name in TABLES
    ]
    loops = [_loop(source, *each) for each in enumerate(controller.loops, start=1)]
    return MapNames(
        where=source.where,
        lockout=lockout_ends(controller),
        block=BLOCK,
        tables=tables,
        sizes={table.name: len(table.rows) for table in tables},
        loops=loops,
        monitors=list(controller.monitors),
        gains=any(loop.tunable for loop in loops),
        state_fault=STATE_FAULT,
        state_valid=STATE_VALID,
        headers=list(_headers(source)),
    )


def _loop(source: Source, number: int, name: str) -> MapLoop:
    facts, experiment = facts_of(source.controller, name), source.controller.loops[name].autotune
    return MapLoop(
        name=name,
        prefix=prefix_of(name),
        block=BLOCK * number,
        tunable=facts.tunable,
        cycles=experiment.cycles if facts.autotune and experiment else None,
        cycles_where=Source(source.spec, ("loops", name, "autotune", "cycles")).where,
    )


def _rows(register: Register) -> list[Row]:
    """One row of the C table for each word."""
    how, place = register.stored.how, register.stored.place
    field = "number" if how == "MAP_NUMBER" else "place"
    if register.words == 1:
        return [_row(register, 0, f".{field} = {place}", "")]
    if field == "number":
        parts = (f"(uint16_t)({place} >> 16)", f"(uint16_t)({place} & 0xFFFFu)")
    else:
        parts = (f"(const uint8_t *){place} + 2", place)
    return [
        _row(register, offset, f".{field} = {part}", f", {half} word")
        for offset, (part, half) in enumerate(zip(parts, ("high", "low"), strict=True))
    ]


def _row(register: Register, offset: int, of: str, half: str) -> Row:
    return Row(register.address + offset, register.stored.how, of, f"{register.name}{half}")


def _headers(source: Source) -> list[Header]:
    """The headers of the variables in the map, each with the variable that it declares."""
    controller = source.controller
    headers = {"fault.h": "fault", "settings.h": "settings"}
    for name, facts in facts_of(controller).loops.items():
        headers[f"loop_{name}.h"] = f"loop_{name}"
        if facts.current is not None:
            headers[f"current_{facts.heater}.h"] = f"current_{facts.heater}"
        if facts.autotune:
            headers[f"autotune_{name}.h"] = f"autotune_{name}"
        if facts.response:
            headers[f"response_{name}.h"] = f"response_{name}"
    for name in controller.monitors:
        headers[f"monitor_{name}.h"] = f"monitor_{name}"
    return [Header(name, symbol) for name, symbol in sorted(headers.items())]
