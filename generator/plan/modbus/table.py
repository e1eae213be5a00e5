"""The register map as the C of the firmware has it."""

from __future__ import annotations

from typing import Any

from heatwright.generator.plan.core import lockout_ends
from heatwright.generator.plan.loop_names import prefix_of
from heatwright.generator.plan.registers import (
    BLOCK,
    STATE_FAULT,
    STATE_VALID,
    Register,
    Table,
    register_map,
)
from heatwright.generator.plan.sensors.common import current_sensor
from heatwright.generator.plan.source import Source
from heatwright.spec.facts import facts_of

TABLES: tuple[Table, ...] = ("coils", "discretes", "holdings", "inputs")


def map_context(source: Source) -> dict[str, Any]:
    """All that the templates of the map need to know."""
    registers = register_map(source.spec)
    tables = [
        {"name": name, "rows": [row for each in registers.table(name) for row in _rows(each)]}
        for name in TABLES
    ]
    loops = _loops(source)
    return {
        "where": source.where,
        "lockout": lockout_ends(source.controller),
        "block": BLOCK,
        "tables": tables,
        "sizes": {str(table["name"]): len(table["rows"]) for table in tables},
        "loops": loops,
        "monitors": list(source.controller.monitors),
        "gains": any(loop["tunable"] for loop in loops),
        "state_fault": STATE_FAULT,
        "state_valid": STATE_VALID,
        "headers": list(_headers(source)),
    }


def _loops(source: Source) -> list[dict[str, Any]]:
    controller = source.controller
    return [
        {
            "name": name,
            "prefix": prefix_of(name),
            "block": BLOCK * number,
            "tunable": facts_of(controller, name).tunable,
            "cycles": loop.autotune.cycles
            if facts_of(controller, name).tunable and loop.autotune is not None
            else None,
            "cycles_where": Source(source.spec, ("loops", name, "autotune", "cycles")).where,
        }
        for number, (name, loop) in enumerate(controller.loops.items(), start=1)
    ]


def _rows(register: Register) -> list[dict[str, Any]]:
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


def _row(register: Register, offset: int, of: str, half: str) -> dict[str, Any]:
    return {
        "address": register.address + offset,
        "how": register.stored.how,
        "of": of,
        "what": f"{register.name}{half}",
    }


def _headers(source: Source) -> list[dict[str, str]]:
    """The headers of what is in the map, each with a name that it is for."""
    controller = source.controller
    headers = {"fault.h": "fault", "settings.h": "settings"}
    for name, loop in controller.loops.items():
        headers[f"loop_{name}.h"] = f"loop_{name}"
        if current_sensor(controller, loop) is not None:
            headers[f"current_{loop.heater}.h"] = f"current_{loop.heater}"
        if facts_of(controller, name).tunable and loop.autotune is not None:
            headers[f"autotune_{name}.h"] = f"autotune_{name}"
        if loop.response is not None:
            headers[f"response_{name}.h"] = f"response_{name}"
    for name in controller.monitors:
        headers[f"monitor_{name}.h"] = f"monitor_{name}"
    return [{"name": name, "symbols": symbol} for name, symbol in sorted(headers.items())]
