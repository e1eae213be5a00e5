"""A host that speaks G-code over the serial line."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from heatwright.generator.plan.core import lockout_ends
from heatwright.generator.plan.numbers import quantity, ticks
from heatwright.generator.plan.parts import (
    Call,
    Constant,
    File,
    Group,
    Part,
    PinPlan,
    Stage,
    Wiring,
    pair,
)
from heatwright.generator.plan.pins import label, pulled_up
from heatwright.generator.plan.protection.monitors import told
from heatwright.generator.plan.source import Source
from heatwright.generator.plan.uart import UartRegisters, registers
from heatwright.spec import Gcode, Rule, facts_of

SILENT_S = 3.0
"""Silence of both sides after which the firmware repeats `ok`."""
MOST_REMINDERS = 5
"""Repeats after which the host is taken to have no more lines."""
SETTLED_S = 10.0
"""Marlin's TEMP_RESIDENCY_TIME: how long the temperature must be near before M109 ends."""
BUSY_S = 2.0
"""Time between two reports of `busy`: Marlin's DEFAULT_KEEPALIVE_INTERVAL."""
SLOWEST_MM_PER_MIN = 1.0
NUMBERS = {"B": 10, "C": 11}
"""Numbers of bed and chamber in the firmware; they follow those of the tools, 0 to 9."""


def plan(source: Source, interface: Gcode) -> Part:
    """Plan the line, the commands and the answers."""
    context = _context(source, interface)
    return Part(
        files=(*_files(context), *told(Source(source.spec, ()))),
        groups=(Group("G-code host", tuple(_constants(source, interface))),),
        pins=(_receiving_pin(source),),
        start_calls=(Call(Stage.OPERATE, "gcode.h", "gcode_start();"),),
        tick_calls=(Call(Stage.OPERATE, "gcode.h", "gcode_tick();"),),
        wiring=tuple(_wiring(source, interface)),
    )


def _files(context: HostNames) -> Iterable[File]:
    for name in ("gcode_line", "gcode_words"):
        yield from pair(name, f"interfaces/gcode/{name}")
    for name in ("gcode", "gcode_report", "gcode_tools", "gcode_wait"):
        yield from pair(name, f"interfaces/gcode/{name}", context)
    feeds = ("gcode_feed",) if context.output is not None else ()
    for name in (*feeds, "host"):
        yield from pair(name, f"interfaces/gcode/{name}", context, plain_header=True)
    yield from pair("text", "interfaces/text")


def _constants(source: Source, interface: Gcode) -> Iterable[Constant]:
    yield source.baud("HOST_DIVISOR", interface.baud)
    yield Constant(
        "HOST_SILENT_TICKS",
        f"{ticks(SILENT_S)}u",
        f"after {quantity(SILENT_S, 's')} of silence the host may have missed an ok",
    )
    yield Constant("HOST_MOST_REMINDERS", f"{MOST_REMINDERS}u", "then the host has no more lines")
    yield Constant(
        "WAIT_SETTLED_TICKS",
        f"{ticks(SETTLED_S)}u",
        f"settled: {quantity(SETTLED_S, 's')} near the setpoint",
    )
    yield Constant("WAIT_BUSY_TICKS", f"{ticks(BUSY_S)}u", f"{quantity(BUSY_S, 's')}")
    if interface.steppers:
        yield source.at("steppers").number(
            "FEED_SLOWEST_MM_PER_MIN", SLOWEST_MM_PER_MIN, "a slower feed is a mistake"
        )


@dataclass(frozen=True, slots=True)
class Heater:
    """A loop that the host commands, by its number in the firmware."""

    number: int
    loop: str
    where: str
    cycles: int | None
    """Default number of cycles of a tuning; None without one."""
    cycles_where: str


@dataclass(frozen=True, slots=True)
class Fan:
    """An output that the host switches."""

    number: int
    output: str
    where: str


@dataclass(frozen=True, slots=True)
class Piece:
    """A number in the report, and the text before it."""

    text: str
    value: str
    decimals: int


@dataclass(frozen=True, slots=True)
class HostNames:
    """The values for the templates of the interface."""

    where: str
    name: str
    digest: str
    rules: tuple[Rule, ...]
    lockout: str
    served: str
    heaters: list[Heater]
    tools: list[Heater]
    bed: Heater | None
    chamber: Heater | None
    tunable: list[Heater]
    limited: list[Heater]
    autotuned: list[Heater]
    fans: list[Fan]
    monitors: bool
    minded: bool
    """True if a loop trips when the host is silent."""
    keyed: bool
    """True if such a loop also has a keypad."""
    temperature_pieces: list[Piece]
    uart: UartRegisters
    setup: list[str]
    output: str | None
    """The stepper that feeds filament."""
    prefix: str
    ready_loops: list[str]


def _context(source: Source, interface: Gcode) -> HostNames:
    controller, uart = source.controller, registers(source.controller.board)
    facts = facts_of(controller)
    heaters = {key: _heater(source, interface, key) for key in sorted(interface.loops, key=_number)}
    tuned = [each for each in heaters.values() if facts.loops[each.loop].tunable]
    minded = [loop for loop in facts.loops.values() if loop.minds_host]
    output = interface.steppers.get("E")
    return HostNames(
        where=source.where,
        name=controller.identity.name,
        digest=source.spec.digest,
        rules=facts.rules,
        lockout=lockout_ends(controller),
        served=_served(interface),
        heaters=list(heaters.values()),
        tools=[heater for key, heater in heaters.items() if key not in NUMBERS],
        bed=heaters.get("B"),
        chamber=heaters.get("C"),
        tunable=tuned,
        limited=[each for each in tuned if facts.loops[each.loop].limits_adjustable],
        autotuned=[each for each in tuned if each.cycles is not None],
        fans=[
            Fan(int(key[1:]), output, source.at("fans", key).where)
            for key, output in sorted(interface.fans.items())
        ],
        monitors=bool(controller.monitors),
        minded=bool(minded),
        keyed=any(loop.keyed for loop in minded),
        temperature_pieces=_temperature_pieces(interface, source.controller.monitors),
        uart=uart,
        setup=[
            *uart.formed("HOST_DIVISOR", "8N1"),
            "/* Without a byte to send, its interrupt switches itself off. */",
            uart.enabled("TXEN", "RXEN", "RXCIE", "UDRIE"),
        ],
        output=output,
        prefix=f"OUTPUT_{output.upper()}" if output else "",
        ready_loops=[
            name for name, loop in controller.loops.items() if loop.ready_within_k is not None
        ],
    )


def _heater(source: Source, interface: Gcode, key: str) -> Heater:
    loop = interface.loops[key]
    experiment = source.controller.loops[loop].autotune
    return Heater(
        number=_number(key),
        loop=loop,
        where=source.at("loops", key).where,
        cycles=experiment.cycles if experiment else None,
        cycles_where=Source(source.spec, ("loops", loop, "autotune", "cycles")).where,
    )


def _number(address: str) -> int:
    """Return the number of a loop in the firmware; a tool's number is unchanged."""
    return NUMBERS[address] if address in NUMBERS else int(address[1:])


def _served(interface: Gcode) -> str:
    """Name the parts that have a number: `Tools, bed and fans by their numbers`."""
    tools = any(key not in NUMBERS for key in interface.loops)
    named = {"tools": tools, "bed": "B" in interface.loops, "chamber": "C" in interface.loops}
    *first, last = [*(each for each, there in named.items() if there), "fans"]
    return f"{', '.join(first)} and {last} by their numbers".capitalize()


def _temperature_pieces(interface: Gcode, monitors: Iterable[str]) -> list[Piece]:
    """Return the numbers of `T:201.3 /200.0 B:60.1 /60.0 @:127 B@:31`, in Marlin's order.

    If there are several tools, the numbers of each follow. Without a tool or a bed it is shown as
    cold and off, because some hosts expect it. Monitors come last, with their names: some hosts
    show them as further sensors.
    """
    tools = sorted(key for key in interface.loops if key not in NUMBERS)
    bed = "TOOL_BED" if "B" in interface.loops else None
    shown = {"T": "report_tool" if tools else None, "B": bed}
    shown |= {"C": "TOOL_CHAMBER"} if "C" in interface.loops else {}
    several = {key: key[1:] for key in tools} if len(tools) > 1 else {}
    numbers: list[tuple[str, str | None, int]] = []
    for key, number in (shown | several).items():
        numbers.append((f" {key}:", number and f"tool_temperature_c({number})", 1))
        numbers.append((" /", number and f"tool_setpoint_c({number})", 1))
    duties = {"@": shown.pop("T"), **{f"{key}@": each for key, each in shown.items() if each}}
    duties |= {f"@{number}": number for number in several.values()}
    numbers += [(f" {key}:", each and f"shown_duty({each})", 0) for key, each in duties.items()]
    numbers += [(f" {name}:", f"monitors_celsius({n})", 1) for n, name in enumerate(monitors, 1)]
    return _pieces(numbers)


def _pieces(numbers: Iterable[tuple[str, str | None, int]]) -> list[Piece]:
    """Join each missing number, as 0, to the text before the next."""
    pieces: list[Piece] = []
    before = ""
    for text, value, decimals in numbers:
        before += text
        if value is None:
            before += f"{0:.{decimals}f}"
        else:
            pieces.append(Piece(before if pieces else before.removeprefix(" "), value, decimals))
            before = ""
    return pieces


def _receiving_pin(source: Source) -> PinPlan:
    board = source.controller.board
    return pulled_up(source, "host_rx", board.pins[board.uarts[0].rx], "from the host")


def _wiring(source: Source, interface: Gcode) -> Iterable[Wiring]:
    board = source.controller.board
    uart = board.uarts[0]
    yield Wiring(label(board.pins[uart.rx]), "G-code host, its transmitter", interface.line.told)
    yield Wiring(label(board.pins[uart.tx]), "G-code host, its receiver", "the same")
