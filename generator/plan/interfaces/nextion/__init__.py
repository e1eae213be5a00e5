"""A Nextion touch display: its line, its commands, its contents, and documents for its editor."""

from collections.abc import Iterable
from dataclasses import dataclass

from heatwright.generator.plan.core import lockout_ends, rule_macro
from heatwright.generator.plan.interfaces.nextion.documents import documents
from heatwright.generator.plan.interfaces.nextion.shown import Begin, Shows, What, components, whats
from heatwright.generator.plan.interfaces.nextion.words import words
from heatwright.generator.plan.numbers import c_float, quantity, ticks, told_period
from heatwright.generator.plan.parts import (
    Call,
    Constant,
    File,
    Group,
    Header,
    Part,
    PinPlan,
    Stage,
    Wiring,
    pair,
)
from heatwright.generator.plan.pins import label, pulled_up
from heatwright.generator.plan.protection.fault_log import fault_log
from heatwright.generator.plan.protection.monitors import told
from heatwright.generator.plan.source import Source
from heatwright.generator.plan.uart import UartRegisters, registers
from heatwright.spec import Nextion, facts_of
from heatwright.spec.board.uart import RECEIVED_TOLERANCE, baud_setting
from heatwright.spec.boards import Uart
from heatwright.spec.interfaces import DISPLAY_BAUDS, FASTER_DISPLAY_BAUDS
from heatwright.spec.nextion import Page, chart_top_c, display_pages, selectable_types
from heatwright.spec.nextion.control import CONTROL_CHART_EVERY_S
from heatwright.spec.nextion.overview import CHART_EVERY_S, CHART_PX
from heatwright.spec.nextion.parts import AMBER, FIELD, GREEN
from heatwright.spec.sensing.max31856 import TYPE_CODES

TURN_S = 0.02
"""Shortest time between two instructions: the display needs time to execute them."""
REFRESH_S = 30.0
"""Time between two refreshes: the longest time for which a disturbed line shows wrong contents."""
SEARCH_S = 3.0
"""Wait for an answer before the search: the display starts in 1 s, and answers within 1 s."""
BEAT_S = CONTROL_CHART_EVERY_S
"""Length of a beat, the unit in which all longer times are counted."""
BYTES_OF_POINT = len("20,743h59.98,-1100.5,4:")
BYTES_OF_ORDER = 32
JOULES_PER_HUNDREDTH_KWH = 36e3
PARTS_OF_DUTY = 1000.0
"""`program.energy` counts tenths of a percent."""


def plan(source: Source, interface: Nextion) -> Part:
    """Plan the display of one loop."""
    log = fault_log()
    return Part(
        files=(*_files(source, interface), *log.files),
        groups=(Group("Touch display", tuple(_constants(source, interface))),),
        pins=(_receiving_pin(source, interface),),
        start_calls=(Call(Stage.OPERATE, "nextion.h", "nextion_start();"),),
        tick_calls=(Call(Stage.OPERATE, "nextion.h", "nextion_tick();"), *log.tick_calls),
        wiring=tuple(_wiring(source, interface)),
    )


def _files(source: Source, interface: Nextion) -> Iterable[File]:
    context = _context(source, interface)
    for stem in ("nextion", "nextion_frame", "nextion_numbers", "nextion_say"):
        yield from pair(stem, f"interfaces/nextion/{stem}")
    points = ("points",) if context.programs else ()
    for name in ("talk", "search", "port", "pages", "show", "chart", "orders", *points):
        template = f"interfaces/nextion/nextion_{name}"
        yield from pair(f"nextion_{name}", template, context, plain_header=True)
    yield from pair("text", "interfaces/text")
    yield from told(Source(source.spec, ()))
    yield from documents(source, interface)


def _uart(source: Source, interface: Nextion) -> Uart:
    return source.controller.board.uarts[interface.port]


@dataclass(frozen=True, slots=True)
class Speed:
    """A baud rate that the display may have, and its divisor."""

    baud: int
    divisor: int


@dataclass(frozen=True, slots=True)
class FaultPage:
    """The page of a rule."""

    macro: str
    number: int
    name: str


@dataclass(frozen=True, slots=True)
class DisplayNames:
    """The values for the templates of the display."""

    where: str
    turn_ms: int
    loop_name: str
    sensor: str
    lockout: str
    programs: bool
    monitors: bool
    tunable: bool
    must_release: bool
    adjustable: bool
    selectable: bool
    top_c: int
    fault_pages: list[FaultPage]
    whats: list[What]
    components: list[Shows]
    name_size: int
    pages: list[Begin]
    most_components: int
    words: list[str]
    word_size: int
    first_words: dict[str, int]
    headers: list[Header]
    uart: UartRegisters
    setup: list[str]
    speeds: list[Speed]


def _context(source: Source, interface: Nextion) -> DisplayNames:
    controller, name = source.controller, interface.loop
    facts, uart = facts_of(controller, name), registers(controller.board, interface.port)
    shown = whats(source, interface)
    found, begins = components(source, shown)
    texts, first = words(controller)
    return DisplayNames(
        where=source.where,
        turn_ms=round(TURN_S * 1000),
        loop_name=name,
        sensor=facts.sensor,
        lockout=lockout_ends(controller),
        programs=facts.programmed,
        monitors=bool(controller.monitors),
        tunable=facts.tunable,
        must_release=facts.must_release,
        adjustable=facts.adjustable,
        selectable=bool(selectable_types(controller)),
        top_c=chart_top_c(controller),
        fault_pages=_fault_pages(source),
        whats=shown,
        components=found,
        name_size=1 + max(len(each.name) for each in found),
        pages=begins,
        most_components=max(page.size for page in begins),
        words=texts,
        word_size=1 + max(map(len, texts)),
        first_words=first,
        headers=_headers(source, interface),
        uart=uart,
        setup=uart.setup("divisor", receives=True),
        speeds=_speeds(source, interface),
    )


def _speeds(source: Source, interface: Nextion) -> list[Speed]:
    """The divisors of all baud rates that the display may have, except that of the spec."""
    clock_hz = source.controller.board.clock_hz
    others = {
        baud: baud_setting(clock_hz, baud)
        for baud in (*DISPLAY_BAUDS, *FASTER_DISPLAY_BAUDS)
        if baud != interface.baud
    }
    return [
        Speed(baud, setting.divisor)
        for baud, setting in others.items()
        if abs(setting.error) <= RECEIVED_TOLERANCE
    ]


def _fault_pages(source: Source) -> list[FaultPage]:
    """The page of each rule that can trip."""
    pages = {page.name: page.id for page in display_pages(source.controller)}
    named = {
        rule_macro(rule): f"fault{rule.code:02d}" for rule in facts_of(source.controller).rules
    }
    return [FaultPage(macro, pages[name], name) for macro, name in named.items()]


def _headers(source: Source, interface: Nextion) -> list[Header]:
    """The headers that the contents need, with the names for which they are included."""
    name, facts = interface.loop, facts_of(source.controller, interface.loop)
    found = {f"loop_{name}.h": f"loop_{name}", "settings.h": "settings"}
    if facts.response:
        found |= {f"response_{name}.h": f"response_{name}"}
    if facts.programmed:
        found |= {"nextion_points.h": "points_*", "program.h": "program"}
        found |= {"progress.h": "progress_saves"}
    return [Header(header, found[header]) for header in sorted(found)]


def _constants(source: Source, interface: Nextion) -> Iterable[Constant]:
    yield source.baud("NEXTION_DIVISOR", interface.baud)
    yield Constant("NEXTION_BAUD", f"{interface.baud}ul", "set in the display")
    turn = f"{quantity(TURN_S * 1e3, 'ms')} at least between two instructions"
    yield Constant("NEXTION_TURN_TICKS", f"{ticks(TURN_S)}u", turn)
    beat = f"{quantity(BEAT_S, 's')}: a pixel of the chart of the last minutes"
    yield Constant("NEXTION_BEAT_TURNS", f"{ticks(BEAT_S) // ticks(TURN_S)}u", beat)
    yield _beats("REFRESH", REFRESH_S, "until everything is sent again")
    yield _beats("SEARCH", SEARCH_S, "without an answer, then other baud rates are tried")
    yield from _command_constants(source, interface)
    yield from _page_constants(display_pages(source.controller))
    yield from _chart_constants(source)


def _beats(name: str, time_s: float, what: str) -> Constant:
    """Return a constant: the beats in a time."""
    beats = ticks(time_s) // ticks(BEAT_S)
    return Constant(f"NEXTION_{name}_BEATS", f"{beats}u", f"{quantity(time_s, 's')} {what}")


def _command_constants(source: Source, interface: Nextion) -> Iterable[Constant]:
    controller = source.controller
    programs = controller.programs if facts_of(controller, interface.loop).programmed else None
    points = 0 if programs is None else programs.points
    yield Constant(
        "NEXTION_ORDER_SIZE",
        f"{BYTES_OF_ORDER + points * BYTES_OF_POINT}u",
        f"the longest command: {points} segments of {BYTES_OF_POINT} characters",
    )
    if selectable_types(controller):
        yield Constant(
            "NEXTION_LAST_TYPE", f"{len(TYPE_CODES) - 1}u", f"types of thermocouple: {TYPE_CODES}"
        )
    if programs is None:
        return
    loop = controller.loops[interface.loop]
    yield Constant(
        "NEXTION_MINUTES_PER_STEP", c_float(loop.period_s / 60), "for the program's clocks"
    )
    power_w = controller.outputs[loop.heater].power_w
    if power_w is not None:
        joules = loop.integral(power_w) / PARTS_OF_DUTY
        yield Source(source.spec, ("outputs", loop.heater, "power")).number(
            "NEXTION_HUNDREDTHS_OF_KWH",
            joules / JOULES_PER_HUNDREDTH_KWH,
            f"{quantity(power_w, 'W')} x {told_period(loop)} / 1000, in 0.01 kWh",
        )
    for name, colour, what in (
        ("PLAIN", FIELD, "any segment"),
        ("MARKED", AMBER, "the segment touched last"),
        ("RUNNING", GREEN, "the running segment"),
    ):
        yield Constant(f"NEXTION_{name}", f"{colour}", f"colour of {what}, 16 bits")


def _page_constants(pages: tuple[Page, ...]) -> Iterable[Constant]:
    numbers = {page.name: page.id for page in pages}
    yield Constant("NEXTION_PAGES", f"{len(pages)}u", "the editor numbers them from 0")
    first = min(
        page.id for page in pages if page.name.startswith("fault") and page.name[5:6] != "s"
    )
    yield Constant("NEXTION_FIRST_FAULT_PAGE", f"{first}u", "then one page for each rule")
    for name in ("main", "points", "debug", "faults"):
        if name in numbers:
            yield Constant(f"PAGE_{name.upper()}", f"{numbers[name]}u", f"page {name}")


def _chart_constants(source: Source) -> Iterable[Constant]:
    pages = {page.name: page for page in display_pages(source.controller)}
    top_c = chart_top_c(source.controller)
    for constant, page in (("NEXTION_CHART_ID", "main"), ("NEXTION_RUNNING_ID", "debug")):
        number = next(each.id for each in pages[page].components if each.name == "chart")
        yield Constant(constant, f"{number}u", f"number of the chart on page {page}")
    width, height = CHART_PX
    hours = quantity(width * CHART_EVERY_S / 3600, "h")
    yield Constant("NEXTION_CHART_COLUMNS", f"{width}u", f"pixels across, {hours}")
    yield Constant("NEXTION_CHART_HEIGHT", f"{height}u", "pixels")
    yield _beats("CHART", CHART_EVERY_S, "per pixel")
    yield Constant("NEXTION_PIXELS_PER_K", c_float(height / top_c), f"{height} px for {top_c} degC")


def _receiving_pin(source: Source, interface: Nextion) -> PinPlan:
    pins = source.controller.board.pins
    return pulled_up(source, "nextion_rx", pins[_uart(source, interface).rx], "from the display")


def _wiring(source: Source, interface: Nextion) -> Iterable[Wiring]:
    board, uart = source.controller.board, _uart(source, interface)
    told = interface.line.told
    yield Wiring(label(board.pins[uart.rx]), "Nextion display, TX (blue)", told)
    yield Wiring(label(board.pins[uart.tx]), "Nextion display, RX (yellow)", "5 V, its own supply")
