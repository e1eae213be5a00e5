"""The LCD keypad shield: its display, its keys, and their functions."""

from dataclasses import dataclass

from heatwright.generator.plan.adc import has_sensors, scan
from heatwright.generator.plan.loop import adjusted
from heatwright.generator.plan.loop.loops import told_between_steps
from heatwright.generator.plan.loop.names import prefix_of
from heatwright.generator.plan.numbers import TICK_MS, quantity, ticks, told_period
from heatwright.generator.plan.parts import Call, Constant, File, Group, Part, Stage, Wiring, pair
from heatwright.generator.plan.pins import driven, pulled_up
from heatwright.generator.plan.programs.menu import Shown, plan_menu
from heatwright.generator.plan.protection.monitors import shown as plan_warning
from heatwright.generator.plan.source import Source
from heatwright.spec import LcdKeypad, Loop, Rule, facts_of
from heatwright.spec.interfaces import LCD_KEYPAD, Countdown

MINUTE_S = 60.0
COARSE = 10
"""Steps of a coarse step, which each repeat of a key makes once the key is held for long."""


@dataclass(frozen=True, slots=True)
class KeypadNames:
    """The values for the templates of the keypad."""

    where: str
    shared_adc: bool
    lockout: bool
    repeats: bool


def plan(source: Source, interface: LcdKeypad) -> Part:
    """Plan the shield for one loop."""
    controller, board = source.controller, source.controller.board
    keys, screen = scan(Source(source.spec, ())), _plan_screen(source)
    by_program = facts_of(controller, interface.loop).programmed
    shown = (plan_menu if by_program else _plan_panel)(source, interface)
    warning_files, warning_constants = plan_warning(Source(source.spec, ()), interface.loop)
    keypad = KeypadNames(
        where=source.where,
        shared_adc=has_sensors(controller),
        lockout=controller.lockout is not None,
        repeats=by_program or interface.countdown is not None,
    )
    constants = (*SCREEN_CONSTANTS, source.at("step").given("PANEL_STEP_K", interface.step_k, "K"))
    return Part(
        files=(
            *keys.files,
            *screen.files,
            *pair("keypad", "interfaces/lcd_keypad/keypad", keypad),
            File("src/panel.h", "interfaces/lcd_keypad/panel.h"),
            *shown.files,
            *warning_files,
            *pair("text", "interfaces/text"),
        ),
        groups=(Group("LCD keypad shield", (*constants, *shown.constants, *warning_constants)),),
        pins=(
            *screen.pins,
            pulled_up(source, "keypad", board.pins[LCD_KEYPAD.keys], "keys of the display shield"),
        ),
        start_calls=(
            *screen.start_calls,
            Call(Stage.SHOW, "panel.h", "panel_refresh();"),
            Call(Stage.OPERATE, "keypad.h", "keypad_start();"),
            *keys.start_calls,
        ),
        tick_calls=(
            Call(Stage.OPERATE, "panel.h", "panel_tick();"),
            *keys.tick_calls,
            *shown.tick_calls,
            *screen.tick_calls,
        ),
        wiring=(
            *screen.wiring,
            Wiring(LCD_KEYPAD.keys, "LCD keypad shield, keys", "resistor ladder"),
        ),
    )


@dataclass(frozen=True, slots=True)
class PanelNames:
    """The values for the template of the panel."""

    where: str
    loop_name: str
    told_between_steps: bool
    prefix: str
    heater: str
    step: str
    rules: tuple[Rule, ...]
    hosted: bool
    minds_host: bool
    must_release: bool
    countdown: bool
    numbers: list[adjusted.NumberNames]
    monitors: bool
    lockout: bool


@dataclass(frozen=True, slots=True)
class CountdownNames:
    """The values for the templates of the countdown."""

    where: str
    loop_name: str
    must_release: bool
    at_once: bool
    counts_where: str


def _plan_panel(source: Source, interface: LcdKeypad) -> Shown:
    """Plan the display of a loop without programs: temperature and setpoint."""
    controller = source.controller
    loop, facts = controller.loops[interface.loop], facts_of(controller, interface.loop)
    panel = PanelNames(
        where=source.where,
        loop_name=interface.loop,
        told_between_steps=told_between_steps(controller, loop),
        prefix=prefix_of(interface.loop),
        heater=loop.heater,
        step=quantity(interface.step_k, "K"),
        rules=facts_of(controller).rules,
        hosted=not facts.switched,
        minds_host=facts.minds_host,
        must_release=facts.must_release,
        countdown=interface.countdown is not None,
        numbers=adjusted.named(source, interface.loop, prefix_of(interface.loop)),
        monitors=bool(controller.monitors),
        lockout=controller.lockout is not None,
    )
    setpoint = loop.setpoint
    shown = interface.step_k, setpoint.initial_c, setpoint.minimum_c, setpoint.maximum_c
    whole = all(value.is_integer() for value in shown)
    constants = (
        Constant(
            "PANEL_SETPOINT_DECIMALS", "0u" if whole else "1u", "as many as the setpoints need"
        ),
        *adjusted.key_constants(source, interface.loop),
    )
    files = (File("src/panel.c", "interfaces/lcd_keypad/panel.c.j2", panel),)
    if interface.countdown is None:
        return Shown(files, constants)
    at = source.at("countdown")
    counted = CountdownNames(
        where=at.where,
        loop_name=interface.loop,
        must_release=panel.must_release,
        at_once=interface.countdown.counts == "at once",
        counts_where=at.at("counts").where,
    )
    added = pair("countdown", "interfaces/lcd_keypad/countdown", counted, key=("countdown",))
    return Shown((*files, *added), (*constants, *_countdown(at, interface.countdown, loop)))


def _countdown(at: Source, countdown: Countdown, loop: Loop) -> tuple[Constant, ...]:
    """Return the countdown's constants: its times in minutes, and the control period in ms."""
    longest, step = (
        round(seconds / MINUTE_S) for seconds in (countdown.longest_s, countdown.step_s)
    )
    coarse = min(COARSE * step, longest)
    return (
        at.at("longest").count("COUNTDOWN_LONGEST_MIN", longest, "the longest time"),
        at.at("step").count("COUNTDOWN_STEP_MIN", step, "per press"),
        Constant("COUNTDOWN_COARSE_MIN", f"{coarse}u", "per repeat of a key held for long"),
        Constant(
            "COUNTDOWN_PERIOD_MS",
            f"{loop.period_ticks * TICK_MS}UL",
            f"control steps of {told_period(loop)}",
        ),
    )


SCREEN_LINES = (("rs", "D8"), ("e", "D9"), ("d4", "D4"), ("d5", "D5"), ("d6", "D6"), ("d7", "D7"))
"""The shield's wiring. D10 is not used: a resistor keeps the backlight on."""

POWER_UP_S = 0.05
"""Wait before the first instruction: 40 ms after 2.7 V (HD44780U data sheet, figure 24)."""
RESYNC_S = 30.0

SCREEN_CONSTANTS = (
    Constant("LCD_POWER_UP_TICKS", f"{ticks(POWER_UP_S)}u", "50 ms; the data sheet requires 40 ms"),
    Constant(
        "LCD_RESYNC_TICKS", f"{ticks(RESYNC_S)}u", f"{RESYNC_S:g} s between start-up sequences"
    ),
)

DATA_LINES = (("d4", 0x10), ("d5", 0x20), ("d6", 0x40), ("d7", 0x80))
"""The four data lines, each with its bit in a byte's upper half."""


@dataclass(frozen=True, slots=True)
class LcdNames:
    """The values for the template of the screen."""

    where: str
    resync_s: str
    data_lines: tuple[tuple[str, int], ...]


def _plan_screen(source: Source) -> Part:
    pins = source.controller.board.pins
    lcd = LcdNames(source.where, f"{RESYNC_S:g}", DATA_LINES)
    return Part(
        files=pair("lcd", "interfaces/lcd/lcd", lcd, plain_header=True),
        pins=tuple(
            driven(source, f"lcd_{name}", pins[pin], f"{name.upper()} of the display")
            for name, pin in SCREEN_LINES
        ),
        start_calls=(Call(Stage.SHOW, "lcd.h", "lcd_start();"),),
        tick_calls=(Call(Stage.SHOW, "lcd.h", "lcd_tick();"),),
        wiring=(
            Wiring(
                " ".join(sorted(pin for _, pin in SCREEN_LINES)),
                "LCD keypad shield, display",
                "D4..D7 data, D8 RS, D9 E, R/W to ground",
                end="data, RS, E",
            ),
        ),
    )
