"""The display on I²C: its bus, its controller, and the page that it shows."""

from __future__ import annotations

from dataclasses import replace

from heatwright.generator.plan.numbers import TICK_MS, quantity, ticks
from heatwright.generator.plan.parts import (
    Call,
    Constant,
    File,
    Group,
    Part,
    PinFunction,
    PinPlan,
    Stage,
    Wiring,
    pair,
    pulled,
)
from heatwright.generator.plan.pins import FAR_PORTS, label, open_drain
from heatwright.generator.plan.source import Source
from heatwright.spec import facts_of
from heatwright.spec.boards import Pin
from heatwright_i2c_lcd.model import I2cLcd

POWER_UP_S = 0.05
"""From an expander's first answer to the display's first instruction: 40 ms after 2.7 V (HD44780U
data sheet, figure 24), for it may have been plugged in just now."""
RETRY_S = 1.0
"""From an expander's silence to the next attempt."""
RESYNC_S = 30.0
REFRESH_S = 0.5
"""Quick enough for temperatures, and seldom enough to be read."""
PULL = "4.7 kΩ"
ROOM = 9
"""Columns beside a loop's name: a blank, and a reading such as `-123.4` with the unit."""


def plan(source: Source, interface: I2cLcd) -> Part:
    """Plan the display of one loop."""
    pins = source.controller.board.pins
    name = _name(source, interface)
    sda, scl = pins[interface.sda], pins[interface.scl]
    context = {
        "name": name,
        "NAME": name.upper(),
        "where": source.where,
        "sda": label(sda),
        "scl": label(scl),
        "columns": interface.columns,
        "rows": interface.rows,
        "row_starts": ", ".join(f"0x{start:02X}" for start in row_starts(interface)),
        "loop_name": interface.loop,
        "title": interface.loop[: interface.columns - ROOM],
        "switched": facts_of(source.controller, interface.loop).switched,
        "rules": facts_of(source.controller).rules,
        "resync_s": f"{RESYNC_S:g}",
    }
    what = "I2C display" if name == interface.kind else f"I2C display {name[-1]}"
    return Part(
        files=(
            *(
                File(
                    f"src/{name}{part}.{end}",
                    f"heatwright_i2c_lcd:i2c_lcd{part}.{end}.j2",
                    context,
                )
                for part in ("", "_bus", "_page")
                for end in ("h", "c")
            ),
            *pair("text", "interfaces/text"),
        ),
        groups=(Group(what, _constants(source, name, interface)),),
        pins=(
            _line(source.at("sda"), f"{name}_sda", sda, "SDA of the display"),
            _line(source.at("scl"), f"{name}_scl", scl, "SCL of the display"),
        ),
        tick_calls=(
            Call(Stage.SHOW, f"{name}_page.h", f"{name}_page_tick();"),
            Call(Stage.SHOW, f"{name}.h", f"{name}_tick();"),
        ),
        wiring=(
            *(
                Wiring(
                    label(pin),
                    what,
                    f"{end}; {PULL} to 5 V at the board, so that it is high without the display",
                    (pulled("up", PULL),),
                    end,
                )
                for pin, end in ((sda, "SDA"), (scl, "SCL"))
            ),
            Wiring("–", what, f"5 V; the jumpers set the address 0x{interface.address:02X}"),
        ),
    )


def _line(source: Source, name: str, pin: Pin, purpose: str) -> PinPlan:
    """Plan a line that is pulled low or released; were its pull-up on, low would be high."""
    line = open_drain(source, name, pin, purpose)
    off = f"PORT{pin.port} &= (uint8_t)~(1u << {pin.bit});"
    added = PinFunction("pull_up_off", "void", (off,), pin.port in FAR_PORTS)
    return replace(line, functions=(*line.functions, added))


def row_starts(interface: I2cLcd) -> tuple[int, ...]:
    """Return the addresses at which the rows begin: of four, two go on where two others end."""
    return (0x00, 0x40, interface.columns, 0x40 + interface.columns)[: interface.rows]


def _name(source: Source, interface: I2cLcd) -> str:
    """Return the C name of a display: its kind, from the second one on with a number."""
    before = source.controller.interfaces[: int(source.path[-1])]
    number = 1 + sum(isinstance(each, I2cLcd) for each in before)
    return interface.kind if number == 1 else f"{interface.kind}_{number}"


def _constants(source: Source, name: str, interface: I2cLcd) -> tuple[Constant, ...]:
    prefix = name.upper()
    where = source.at("address").where
    return (
        Constant(
            f"{prefix}_ADDRESS",
            f"0x{interface.address << 1:02X}u",
            f"{where}: 0x{interface.address:02X}, and the bit that says it is written to",
        ),
        _ticks(f"{prefix}_POWER_UP_TICKS", POWER_UP_S, "the data sheet requires 40 ms"),
        _ticks(f"{prefix}_RETRY_TICKS", RETRY_S, "from no answer to the next attempt"),
        _ticks(f"{prefix}_RESYNC_TICKS", RESYNC_S, "between two start-up sequences"),
        _ticks(f"{prefix}_REFRESH_TICKS", REFRESH_S, "between two looks at the loop"),
    )


def _ticks(name: str, duration_s: float, what: str) -> Constant:
    count = ticks(duration_s)
    return Constant(name, f"{count}u", f"{quantity(count * TICK_MS, 'ms')}; {what}")
