"""One line of numbers a period for the program Serial Port Plotter."""

from __future__ import annotations

from heatwright.generator.plan.loops import prefix_of
from heatwright.generator.plan.parts import Call, Constant, File, Group, Part, Stage, Wiring
from heatwright.generator.plan.pins import label
from heatwright.generator.plan.source import Source
from heatwright.spec import Loop, OnOff, Pid, SerialPlotter
from heatwright.spec.boards import Board
from heatwright.spec.uart import baud_setting

DECIMALS = 2

ONE_UART = {"atmega328p"}
"""Chips whose only serial port has a number in its registers, but none in its vectors."""


def plan(source: Source, interface: SerialPlotter) -> Part:
    """Plan transmitter and plotter for one loop."""
    controller = source.controller
    board, loop = controller.board, controller.loops[interface.loop]
    setting = baud_setting(board.clock_hz, interface.baud)
    constants = (
        source.at("baud").count(
            "SERIAL_DIVISOR", setting.divisor, f"{interface.baud} baud, really {setting.baud:.0f}"
        ),
        Constant("PLOTTER_DECIMALS", f"{DECIMALS}u", "of every field"),
    )
    plotter = {
        "where": source.where,
        "loop_name": interface.loop,
        "fields": fields(interface.loop, loop),
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


def _registers(board: Board) -> dict[str, object]:
    number = board.uarts[0].suffix
    alone = board.mcu in ONE_UART
    return {
        "vector": "USART_UDRE_vect" if alone else f"USART{number}_UDRE_vect",
        "data": f"UDR{number}",
        "setup": [
            f"UBRR{number} = SERIAL_DIVISOR;",
            f"UCSR{number}A = (1u << U2X{number});",
            f"UCSR{number}C = (1u << UCSZ{number}1) | (1u << UCSZ{number}0); /* 8N1 */",
            f"UCSR{number}B = (1u << TXEN{number});",
        ],
        "interrupt_on": f"UCSR{number}B |= (1u << UDRIE{number});",
        "interrupt_off": f"UCSR{number}B &= (uint8_t)~(1u << UDRIE{number});",
    }


def fields(name: str, loop: Loop) -> list[dict[str, str]]:
    """The fields of one line: title and C expression."""
    common = [
        ("temperature in degC", f"loop_{name}.temperature_c"),
        ("setpoint in degC", f"loop_{name}.setpoint_c"),
    ]
    prefix, state = prefix_of(name), f"algorithm_{name}"
    if isinstance(loop.algorithm, OnOff):
        lead = f"{prefix}_LEAD_S * {state}.rate_k_per_s" if loop.algorithm.lead_s > 0 else "0.0f"
        own = [
            ("heater, 0 or 10", f"0.1f * loop_{name}.duty_percent"),
            ("lead in K", lead),
        ]
    else:
        own = _pid_fields(name, loop.algorithm, prefix, state)
    return [{"title": title, "expression": expression} for title, expression in common + own]


def _pid_fields(name: str, algorithm: Pid, prefix: str, state: str) -> list[tuple[str, str]]:
    return [
        ("P in %", f"{state}.proportional"),
        ("I in %", f"{state}.integral" if algorithm.ki > 0 else "0.0f"),
        ("D in %", f"{prefix}_KD * {state}.derivative" if algorithm.kd > 0 else "0.0f"),
        ("sum / 10 in %", f"0.1f * {state}_unlimited()"),
        ("duty / 10 in %", f"0.1f * loop_{name}.duty_percent"),
    ]
