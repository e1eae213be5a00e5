"""The menu of the LCD keypad shield for a loop with programs: screens, texts, changes."""

from dataclasses import dataclass
from typing import NamedTuple

from heatwright.generator.plan.core import lockout_ends
from heatwright.generator.plan.loop.loops import told_between_steps
from heatwright.generator.plan.loop.names import CodedType, prefix_of
from heatwright.generator.plan.numbers import c_float, quantity, told_period
from heatwright.generator.plan.parts import Call, Constant, File, pair
from heatwright.generator.plan.protection.fault_log import fault_log
from heatwright.generator.plan.source import Source
from heatwright.spec import LcdKeypad, Rule, facts_of
from heatwright.spec.loops import Loop
from heatwright.spec.sensing.max31856 import TYPE_CODES

WIDE_C = 1000.0
"""From this temperature on, °C, no decimals are shown, so that two temperatures fit in a line."""

JOULE_PER_KWH = 3.6e6
TENTHS_PER_DUTY = 1000
"""Value that the energy counter adds per step at full power."""


class Shown(NamedTuple):
    """The files of a display, with their constants and calls."""

    files: tuple[File, ...]
    constants: tuple[Constant, ...]
    tick_calls: tuple[Call, ...] = ()


@dataclass(frozen=True, slots=True)
class MenuNames:
    """The values for the templates of the menu."""

    where: str
    loop_name: str
    told_between_steps: bool
    prefix: str
    sensor: str
    rules: tuple[Rule, ...]
    lockout: str
    keeps: bool
    decimals: int
    tunable: bool
    adjustable: bool
    types: list[CodedType]
    energy: bool
    monitors: bool


def plan_menu(source: Source, interface: LcdKeypad) -> Shown:
    """Plan the menu of one loop with programs."""
    controller = source.controller
    name = interface.loop
    loop, facts = controller.loops[name], facts_of(controller, name)
    sensor = controller.thermometers[loop.sensor]
    power_w = controller.outputs[loop.heater].power_w
    context = MenuNames(
        where=source.where,
        loop_name=name,
        told_between_steps=told_between_steps(controller, loop),
        prefix=prefix_of(name),
        sensor=loop.sensor,
        rules=facts_of(controller).rules,
        lockout=lockout_ends(controller),
        keeps=controller.programs is not None and controller.programs.on_fault == "pause",
        decimals=int(loop.protection.maximum_c < WIDE_C),
        tunable=facts.tunable,
        adjustable=facts.adjustable,
        types=[CodedType(letter, TYPE_CODES.index(letter)) for letter in sensor.selectable],
        energy=power_w is not None,
        monitors=bool(controller.monitors),
    )
    log = fault_log()
    files = (
        *log.files,
        File("src/panel.c", "interfaces/lcd_keypad/menu.c.j2", context),
        *pair("menu_text", "interfaces/lcd_keypad/menu_text", context),
        *(
            file
            for name in ("menu_run", "menu_edit", "menu_values")
            for file in pair(name, f"interfaces/lcd_keypad/{name}", context, plain_header=True)
        ),
    )
    return Shown(
        files,
        (*_constants(source, loop, interface.step_k), *_energy(source, loop, power_w)),
        log.tick_calls,
    )


def _constants(source: Source, loop: Loop, step_k: float) -> tuple[Constant, ...]:
    return (
        Constant(
            "PANEL_PERIOD_TICKS",
            f"{loop.period_ticks}UL",
            f"a control step of {told_period(loop)}, in ticks of 10 ms",
        ),
        Constant(
            "PANEL_TARGET_STEP",
            f"{max(1, round(step_k * 10))}",
            f"{source.at('step').where}: {quantity(step_k, 'K')}, in 0.1 K",
        ),
    )


def _energy(source: Source, loop: Loop, power_w: float | None) -> tuple[Constant, ...]:
    if power_w is None:
        return ()
    kwh = loop.integral(power_w) / TENTHS_PER_DUTY / JOULE_PER_KWH
    heater = Source(source.spec, ("outputs", loop.heater, "power"))
    return (
        Constant(
            "PANEL_KWH_PER_COUNT",
            c_float(kwh),
            f"{heater.where}: {quantity(power_w, 'W')} x {told_period(loop)} / 1000 / 3.6e6 J",
        ),
    )
