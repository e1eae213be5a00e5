"""One line of numbers per period, for the program Serial Port Plotter."""

from dataclasses import dataclass

from heatwright.generator.plan.loop.names import prefix_of
from heatwright.generator.plan.parts import Call, Constant, Group, Part, Stage, Wiring, pair
from heatwright.generator.plan.pins import label
from heatwright.generator.plan.source import Source
from heatwright.generator.plan.uart import UartRegisters, registers
from heatwright.spec import Controller, Pid, SerialPlotter, facts_of


@dataclass(frozen=True, slots=True)
class SerialNames:
    """The values for the template of the transmitter."""

    uart: UartRegisters
    setup: list[str]


@dataclass(frozen=True, slots=True)
class Field:
    """A number in a line: its title, and its C expression."""

    title: str
    expression: str


@dataclass(frozen=True, slots=True)
class PlotterNames:
    """The values for the template of the plotter."""

    where: str
    loop_name: str
    with_return: bool
    fields: list[Field]


def plan(source: Source, interface: SerialPlotter) -> Part:
    """Plan transmitter and plotter for one loop."""
    controller = source.controller
    board = controller.board
    uart = registers(board)
    setup = uart.setup("SERIAL_DIVISOR", receives=False)
    constants = (source.baud("SERIAL_DIVISOR", interface.baud), _decimals(source, interface))
    plotter = PlotterNames(
        where=source.where,
        loop_name=interface.loop,
        with_return=interface.line_end == "CR LF",
        fields=fields(controller, interface.loop),
    )
    return Part(
        files=(
            *pair("serial", "peripherals/serial", SerialNames(uart, setup), plain_header=True),
            *pair("plotter", "interfaces/serial_plotter/plotter", plotter, plain_header=True),
            *pair("text", "interfaces/text"),
        ),
        groups=(Group("Serial plotter", constants),),
        tick_calls=(Call(Stage.SHOW, "plotter.h", "plotter_tick();"),),
        wiring=(
            Wiring(
                label(board.pins[board.uarts[0].tx]),
                "serial plotter",
                f"{interface.line.told}, sends only",
                end="receiver",
            ),
        ),
    )


def _decimals(source: Source, interface: SerialPlotter) -> Constant:
    name, what = "PLOTTER_DECIMALS", "decimals of every number"
    if "decimals" in interface.model_fields_set:
        return source.at("decimals").count(name, interface.decimals, what)
    return Constant(name, f"{interface.decimals}u", what)


def fields(controller: Controller, name: str) -> list[Field]:
    """The fields of one line: title and C expression."""
    loop, facts = controller.loops[name], facts_of(controller, name)
    keyed = [each.kind.field for each in facts.keyed_numbers]
    common = [
        ("temperature in degC", f"loop_{name}.temperature_c"),
        ("setpoint in degC", f"loop_{name}.setpoint_c"),
    ]
    prefix, state = prefix_of(name), f"algorithm_{name}"
    if loop.algorithm.pid is None:
        lead = f"{prefix}_LEAD_S * {state}.rate_k_per_s" if loop.algorithm.lead_s > 0 else "0.0f"
        if "lead_s" in keyed:
            lead = f"{state}.lead_s * {state}.rate_k_per_s"
        own = [("heater, 0 or 10", f"0.1f * loop_{name}.duty_percent"), ("lead in K", lead)]
    else:
        own = _pid_fields(name, loop.algorithm, prefix, state, variable=facts.gains_vary)
    return [Field(title, expression) for title, expression in common + own]


def _pid_fields(
    name: str, algorithm: Pid, prefix: str, state: str, *, variable: bool
) -> list[tuple[str, str]]:
    kd = f"{state}.kd" if variable else f"{prefix}_KD"
    return [
        ("P in %", f"{state}.proportional"),
        ("I in %", f"{state}.integral" if variable or algorithm.ki > 0 else "0.0f"),
        ("D in %", f"{kd} * {state}.derivative" if variable or algorithm.kd > 0 else "0.0f"),
        ("sum / 10 in %", f"0.1f * {state}_unlimited()"),
        ("duty / 10 in %", f"0.1f * loop_{name}.duty_percent"),
    ]
