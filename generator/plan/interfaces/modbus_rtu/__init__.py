"""The slave of a Modbus line: its frames, its functions, its register map."""

from collections.abc import Iterable
from dataclasses import dataclass

from heatwright.generator.plan import linuxcnc
from heatwright.generator.plan.interfaces.modbus_rtu.documents import documents
from heatwright.generator.plan.interfaces.modbus_rtu.silence import (
    FASTEST_COUNTED_BAUD,
    SILENT_CHARACTERS,
    silence_s,
)
from heatwright.generator.plan.interfaces.modbus_rtu.table import map_names
from heatwright.generator.plan.numbers import quantity
from heatwright.generator.plan.parts import (
    Call,
    Constant,
    File,
    Group,
    Part,
    PinPlan,
    Stage,
    Told,
    Wiring,
    pair,
)
from heatwright.generator.plan.pins import driven, label, pulled_up
from heatwright.generator.plan.registers import VERSION
from heatwright.generator.plan.source import Source
from heatwright.generator.plan.text import c_string
from heatwright.generator.plan.timers import TimerRegisters, free_running, round_interval
from heatwright.generator.plan.timers import registers as timer_registers
from heatwright.generator.plan.uart import UartRegisters, registers
from heatwright.spec import ModbusRtu
from heatwright.spec.board.timers import Interval, allocate

VENDOR = "heatwright"


def plan(source: Source, interface: ModbusRtu) -> Part:
    """Plan the line, the functions and the register map."""
    silence = _silence(source, interface)
    return Part(
        files=tuple(_files(source, interface, silence)),
        groups=(Group("Modbus", tuple(_constants(source, interface, silence))),),
        pins=tuple(_pins(source, interface)),
        start_calls=(Call(Stage.OPERATE, "modbus.h", "modbus_start();"),),
        tick_calls=(Call(Stage.OPERATE, "modbus.h", "modbus_tick();"),),
        wiring=tuple(_wiring(source, interface)),
    )


def _files(source: Source, interface: ModbusRtu, silence: tuple[int, Interval]) -> Iterable[File]:
    for name in ("modbus", "modbus_values"):
        yield from pair(name, f"interfaces/modbus_rtu/{name}")
    told: dict[str, Told] = {
        "modbus_line": _line(source, interface, silence),
        "modbus_identity": _identity(source),
    }
    for name, context in told.items():
        yield from pair(name, f"interfaces/modbus_rtu/{name}", context, plain_header=True)
    yield from documents(source, interface)
    yield from pair("modbus_map", "interfaces/modbus_rtu/modbus_map", map_names(source))
    if interface.linuxcnc:
        yield from linuxcnc.files(source, interface)


def _silence(source: Source, interface: ModbusRtu) -> tuple[int, Interval]:
    """Return the timer that measures the silence, and its interval."""
    board = source.controller.board
    timer = allocate(source.controller).silence
    assert timer is not None  # noqa: S101 - the allocation gives a Modbus line one
    return timer, round_interval(board.clock_hz, board.timers[timer], silence_s(interface))


def _constants(
    source: Source, interface: ModbusRtu, silence: tuple[int, Interval]
) -> Iterable[Constant]:
    timer, interval = silence
    yield source.baud("MODBUS_DIVISOR", interface.baud)
    yield source.at("address").count("MODBUS_ADDRESS", interface.address, "this slave")
    why = (
        f"{SILENT_CHARACTERS} characters of {interface.character_bits} bits"
        if interface.baud <= FASTEST_COUNTED_BAUD
        else f"fixed above {FASTEST_COUNTED_BAUD} baud"
    )
    yield source.at("baud").count(
        "MODBUS_SILENCE_COUNTS",
        interval.counts,
        f"{quantity(silence_s(interface) * 1e3, 'ms')}, {why}; timer {timer}, "
        f"clock / {interval.prescaler}",
    )
    if interval.divider > 1:
        yield Constant("MODBUS_SILENCE_MATCHES", f"{interval.divider}u", "intervals per silence")
    yield Constant("MODBUS_MAP_VERSION", f"{VERSION}u", "version of the register map")


@dataclass(frozen=True, slots=True)
class LineNames:
    """The values for the templates of the line.

    divider -- matches of the timer in a silence; listening, speaking -- C that enables the receiver
    with the transmitter, or the transmitter alone; driver -- the line has an RS-485 driver.
    """

    where: str
    silence: str
    timer: TimerRegisters
    divider: int
    uart: UartRegisters
    setup: list[str]
    listening: str
    speaking: str
    driver: bool


def _line(source: Source, interface: ModbusRtu, silence: tuple[int, Interval]) -> LineNames:
    board = source.controller.board
    number, interval = silence
    timer, uart = timer_registers(board, number), registers(board)
    return LineNames(
        where=source.where,
        silence=quantity(silence_s(interface) * 1e3, "ms"),
        timer=timer,
        divider=interval.divider,
        uart=uart,
        setup=[
            *uart.formed("MODBUS_DIVISOR", interface.line.form),
            *free_running(timer, interval.prescaler),
        ],
        listening=uart.enabled("TXEN", "TXCIE", "RXEN", "RXCIE"),
        speaking=uart.enabled("TXEN", "TXCIE"),
        driver=interface.driver_enable is not None,
    )


@dataclass(frozen=True, slots=True)
class IdentityNames:
    """The identification of the slave, as C."""

    loops: list[str]
    vendor: str
    code: str
    revision: str
    product: str


def _identity(source: Source) -> IdentityNames:
    identity = source.controller.identity
    return IdentityNames(
        loops=list(source.controller.loops),
        vendor=c_string(VENDOR),
        code=c_string(identity.name),
        revision=c_string(f"{VERSION} {source.spec.digest}"),
        product=c_string(identity.title or identity.name),
    )


def _pins(source: Source, interface: ModbusRtu) -> Iterable[PinPlan]:
    board = source.controller.board
    yield pulled_up(source, "modbus_rx", board.pins[board.uarts[0].rx], "from the master")
    if interface.driver_enable is not None:
        yield driven(
            source.at("driver_enable"),
            "modbus_driver",
            board.pins[interface.driver_enable],
            "RS-485 driver, high sends",
        )


def _wiring(source: Source, interface: ModbusRtu) -> Iterable[Wiring]:
    board = source.controller.board
    uart = board.uarts[0]
    yield Wiring(label(board.pins[uart.rx]), "Modbus, from the master", interface.line.told)
    yield Wiring(label(board.pins[uart.tx]), "Modbus, to the master", "the same")
    if interface.driver_enable is not None:
        yield Wiring(
            label(board.pins[interface.driver_enable]),
            "Modbus, DE of the RS-485 driver",
            "high while the slave sends; /RE may be tied to it",
        )
