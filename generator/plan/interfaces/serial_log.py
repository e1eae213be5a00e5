"""A log of a loop in a ring buffer, read over a serial port."""

from dataclasses import dataclass

from heatwright.generator.plan.numbers import quantity, ticks
from heatwright.generator.plan.parts import Call, Constant, File, Group, Part, Stage, Wiring, pair
from heatwright.generator.plan.pins import label, pulled_up
from heatwright.generator.plan.protection.monitors import told
from heatwright.generator.plan.source import Source
from heatwright.generator.plan.uart import UartRegisters, registers
from heatwright.spec import SerialLog, facts_of
from heatwright.spec.board.eeprom import layout


@dataclass(frozen=True, slots=True)
class LogNames:
    """The values for the templates of the log."""

    where: str
    keep_where: str
    loop_name: str
    programs: bool
    response: bool
    response_where: str
    programmed: bool
    monitors: bool
    uart: UartRegisters
    setup: list[str]


def plan(source: Source, interface: SerialLog) -> Part:
    """Plan the ring, its entries, and the commands that read it."""
    board, facts = source.controller.board, facts_of(source.controller, interface.loop)
    kept = interface.keep == "eeprom"
    context = LogNames(
        where=source.where,
        keep_where=source.at("keep").where,
        loop_name=interface.loop,
        programs=source.controller.programs is not None,
        response=facts.response,
        response_where=Source(source.spec, ("loops", interface.loop, "response")).where,
        programmed=facts.programmed,
        monitors=bool(source.controller.monitors),
        uart=registers(board, interface.port),
        setup=registers(board, interface.port).setup("LOG_DIVISOR", receives=True),
    )
    start = [Call(Stage.OPERATE, "log_port.h", "log_port_set_registers();")]
    tick = [Call(Stage.SHOW, "log.h", "log_tick();")]
    ring = [File("src/log_ring.h", "interfaces/serial_log/log_ring.h.j2", context)]
    if kept:
        start.append(Call(Stage.RESTORE, "log_ring_eeprom.h", "log_ring_start();"))
        tick.append(Call(Stage.STORE, "log_ring_eeprom.h", "log_ring_tick();"))
        ring += [
            File("src/log_ring_eeprom.h", "interfaces/serial_log/log_ring_eeprom.h"),
            File("src/log_ring.c", "interfaces/serial_log/log_ring_eeprom.c.j2", context),
        ]
    else:
        ring.append(File("src/log_ring.c", "interfaces/serial_log/log_ring_ram.c.j2", context))
    uart = board.uarts[interface.port]
    receives = board.pins[uart.rx]
    line = interface.line.told
    return Part(
        files=(
            *(
                file
                for name in ("log", "log_note", "log_talk", "log_port")
                for file in pair(name, f"interfaces/serial_log/{name}", context, plain_header=True)
            ),
            *ring,
            *told(Source(source.spec, ())),
            *(pair("text", "interfaces/text") if source.controller.monitors else ()),
        ),
        groups=(Group("Serial log", _constants(source, interface)),),
        pins=(pulled_up(source, "log_rx", receives, "from the computer that reads the log"),),
        start_calls=tuple(start),
        tick_calls=tuple(tick),
        wiring=(
            Wiring(label(board.pins[uart.tx]), "serial log, to the computer", line),
            Wiring(label(receives), "serial log, from the computer", f"{line}; send `help`"),
        ),
    )


def _constants(source: Source, interface: SerialLog) -> tuple[Constant, ...]:
    controller = source.controller
    every = source.at("every")
    shown = quantity(interface.every_s, "s")
    constants = [
        source.baud("LOG_DIVISOR", interface.baud),
        every.count("LOG_EVERY_S", round(interface.every_s), "from one entry to the next"),
        Constant("LOG_EVERY_TICKS", f"{ticks(interface.every_s)}ul", f"{every.where}: {shown}"),
        source.at("entries").count(
            "LOG_ENTRIES",
            interface.entries,
            f"the newest {quantity(interface.entries * interface.every_s / 3600, 'h')}",
        ),
    ]
    if interface.keep == "eeprom":
        area = layout(controller).history
        constants += [
            source.at("keep").count("LOG_EEPROM", area.start, "first byte of the log in EEPROM"),
            Constant(
                "LOG_SLOT_BYTES",
                f"{area.slot_bytes}u",
                f"bytes per entry; cells last {area.years(interface.every_s):.0f} years",
            ),
        ]
    return tuple(constants)
