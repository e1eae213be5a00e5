"""One line of numbers a period for the program Serial Port Plotter."""

from __future__ import annotations

from heatwright.generator.plan.loops import prefix_of
from heatwright.generator.plan.parts import Call, Constant, File, Group, Part, Stage, Wiring
from heatwright.generator.plan.pins import label
from heatwright.generator.plan.source import Source
from heatwright.generator.plan.uart import registers
from heatwright.spec import Loop, Pid, SerialPlotter
from heatwright.spec.boards import Board
from heatwright.spec.commands import tunable
from heatwright.spec.uart import baud_setting


def plan(source: Source, interface: SerialPlotter) -> Part:
    """Plan transmitter and plotter for one loop."""
    controller = source.controller
    board, loop = controller.board, controller.loops[interface.loop]
    setting = baud_setting(board.clock_hz, interface.baud)
    constants = (
        source.at("baud").count(
            "SERIAL_DIVISOR", setting.divisor, f"{interface.baud} baud, really {setting.baud:.0f}"
        ),
        _decimals(source, interface),
    )
    plotter = {
        "where": source.where,
        "loop_name": interface.loop,
        "with_return": interface.line_end == "CR LF",
        "fields": fields(interface.loop, loop, by_host=tunable(controller, interface.loop)),
    }
    return Part(
        files=(
            File("src/serial.h", "src/serial.h"),
            File("src/serial.c", "src/serial.c.j2", _registers(board)),
            File("src/plotter.h", "interfaces/plotter.h"),
            File("src/plotter.c", "interfaces/plotter.c.j2", plotter),
            File("src/text.h", "src/text.h"),
            File("src/text.c", "src/text.c"),
        ),
        groups=(Group("Serial plotter", constants),),
        start_calls=(Call(Stage.SHOW, "serial.h", "serial_start();"),),
        tick_calls=(Call(Stage.SHOW, "plotter.h", "plotter_tick();"),),
        wiring=(
            Wiring(
                label(board.pins[board.uarts[0].tx]),
                "serial plotter",
                f"{interface.baud} baud, 8N1, sends only",
            ),
        ),
    )


def _decimals(source: Source, interface: SerialPlotter) -> Constant:
    name, what = "PLOTTER_DECIMALS", "of every field"
    if "decimals" in interface.model_fields_set:
        return source.at("decimals").count(name, interface.decimals, what)
    return Constant(name, f"{interface.decimals}u", what)


def _registers(board: Board) -> dict[str, object]:
    uart = registers(board)
    return {
        "vector": uart.send_vector,
        "data": uart.data,
        "setup": uart.setup("SERIAL_DIVISOR", receives=False),
        "interrupt_on": uart.interrupt_on,
        "interrupt_off": uart.interrupt_off,
    }


def fields(name: str, loop: Loop, *, by_host: bool) -> list[dict[str, str]]:
    """The fields of one line: title and C expression."""
    common = [
        ("temperature in degC", f"loop_{name}.temperature_c"),
        ("setpoint in degC", f"loop_{name}.setpoint_c"),
    ]
    prefix, state = prefix_of(name), f"algorithm_{name}"
    if not isinstance(loop.algorithm, Pid):
        lead = f"{prefix}_LEAD_S * {state}.rate_k_per_s" if loop.algorithm.lead_s > 0 else "0.0f"
        own = [
            ("heater, 0 or 10", f"0.1f * loop_{name}.duty_percent"),
            ("lead in K", lead),
        ]
    else:
        own = _pid_fields(name, loop.algorithm, prefix, state, by_host=by_host)
    return [{"title": title, "expression": expression} for title, expression in common + own]


def _pid_fields(
    name: str, algorithm: Pid, prefix: str, state: str, *, by_host: bool
) -> list[tuple[str, str]]:
    kd = f"{state}.kd" if by_host else f"{prefix}_KD"
    return [
        ("P in %", f"{state}.proportional"),
        ("I in %", f"{state}.integral" if by_host or algorithm.ki > 0 else "0.0f"),
        ("D in %", f"{kd} * {state}.derivative" if by_host or algorithm.kd > 0 else "0.0f"),
        ("sum / 10 in %", f"0.1f * {state}_unlimited()"),
        ("duty / 10 in %", f"0.1f * loop_{name}.duty_percent"),
    ]
