"""LEDs that show what a loop does: lit, blinking or dark."""

from dataclasses import dataclass

from heatwright.generator.plan.numbers import TICK_MS, ticks
from heatwright.generator.plan.parts import (
    Call,
    Constant,
    Group,
    Header,
    Part,
    Stage,
    Symbol,
    Wiring,
    pair,
)
from heatwright.generator.plan.pins import label, switched
from heatwright.generator.plan.source import Source
from heatwright.spec import Indicators, Loop, facts_of
from heatwright.spec.commands import shown_loop

BLINK_S = 0.5
"""Time on, and time off, of a blinking LED: too long to look like a PWM."""

LOST_AFTER_S = 5.0
"""Silence after which the master is shown as lost, if no rule has a time for it."""

SHOWS = {
    "enabled": "lit: enabled; blinking: fault; dark: disabled",
    "heating": "lit: heater on; blinking: limited by its current",
    "cooling": "lit: cooler on",
    "warm": "lit: near the setpoint; blinking: not yet near; dark: disabled",
    "communicating": "lit: master heard; blinking: master lost; dark: never heard",
    "fault": "blinking: fault",
}
"""Meaning of each LED's states, for the README."""


@dataclass(frozen=True, slots=True)
class IndicatorNames:
    """The values for the templates of the LEDs."""

    where: str
    loop_name: str
    LOOP: str
    heater: str
    cooler: str | None
    limited: bool
    meanings: list[str]
    headers: list[Header]
    leds: list[tuple[str, list[str]]]
    """For each meaning, the C function that lights its LEDs, and the C names of their pins."""


def plan(source: Source, interface: Indicators) -> Part:
    """Plan the LEDs of one loop."""
    name = shown_loop(source.controller, interface)
    loop = source.controller.loops[name]
    pins = _pins(name, interface)
    context = IndicatorNames(
        where=source.where,
        loop_name=name,
        LOOP=name.upper(),
        heater=loop.heater,
        cooler=loop.cooler,
        limited=_limited(source, name),
        meanings=list(pins),
        headers=_headers(source, name, loop, set(pins)),
        leds=[
            ("latched" if meaning == "fault" else meaning, list(named))
            for meaning, named in pins.items()
        ],
    )
    header = f"indicators_{name}.h"
    board_pins = source.controller.board.pins
    leds = [
        (pin_name, meaning, board_pins[pin])
        for meaning, named in pins.items()
        for pin_name, pin in named.items()
    ]
    return Part(
        files=pair(f"indicators_{name}", "interfaces/indicators/indicators", context),
        groups=_groups(source, name, loop, set(pins)),
        pins=tuple(
            switched(source.at("leds"), pin_name, pin, interface.active, f"LED `{meaning}`")
            for pin_name, meaning, pin in leds
        ),
        start_calls=(Call(Stage.SHOW, header, f"indicators_{name}_start();"),),
        tick_calls=(Call(Stage.SHOW, header, f"indicators_{name}_tick();"),),
        wiring=tuple(
            Wiring(
                label(pin),
                f"LED `{meaning}` of `{name}`",
                f"active {interface.active}, with its resistor; {SHOWS[meaning]}",
                (
                    Symbol("along", "resistor", "resistor"),
                    Symbol("down" if interface.active == "high" else "up", "led", meaning),
                ),
                ends=False,
            )
            for _, meaning, pin in leds
        ),
    )


def _pins(loop: str, interface: Indicators) -> dict[str, dict[str, str]]:
    """Return the pins of each meaning, by the C names of the pins."""
    found: dict[str, dict[str, str]] = {}
    for pin, meaning in interface.leds.items():
        same = found.setdefault(meaning, {})
        number = f"_{len(same) + 1}" if same else ""
        same[f"led_{loop}_{meaning}{number}"] = pin
    return found


def _limited(source: Source, name: str) -> bool:
    current = facts_of(source.controller, name).current
    return current is not None and current.limit_a is not None


def _headers(source: Source, name: str, loop: Loop, meanings: set[str]) -> list[Header]:
    """The headers that the LEDs need, with the names for which they are included."""
    symbols: dict[str, list[str]] = {}

    def need(meaning: str, header: str, *needed: str) -> None:
        if meaning in meanings:
            symbols.setdefault(header, []).extend(needed)

    for meaning in ("enabled", "fault"):
        need(meaning, "fault.h", "fault")
    need("enabled", f"loop_{name}.h", f"loop_{name}_works")
    need("warm", f"loop_{name}.h", f"loop_{name}_state", "STATE_*")
    need("heating", f"output_{loop.heater}.h", f"output_{loop.heater}_is_on")
    if _limited(source, name):
        need("heating", f"current_{loop.heater}.h", f"current_{loop.heater}")
        need("heating", f"loop_{name}.h", f"loop_{name}")
    need("cooling", f"output_{loop.cooler}.h", f"output_{loop.cooler}_is_on")
    need("communicating", "modbus.h", "modbus_silent_ticks", "modbus_was_heard")
    symbols["pins.h"] = [f"pin_led_{name}_*"]
    return [Header(header, ", ".join(dict.fromkeys(symbols[header]))) for header in sorted(symbols)]


def _groups(source: Source, name: str, loop: Loop, meanings: set[str]) -> tuple[Group, ...]:
    blink = Constant(
        "INDICATORS_BLINK_TICKS", f"{ticks(BLINK_S)}u", f"{ticks(BLINK_S) * TICK_MS} ms on or off"
    )
    common = Group("Indicators", (blink,))
    if "communicating" not in meanings:
        return (common,)
    given_s = loop.protection.master_lost_after_s
    lost_s = LOST_AFTER_S if given_s is None else given_s
    lost = Source(source.spec, ("loops", name, "protection", "master_lost_after")).ticks(
        f"INDICATORS_{name.upper()}_LOST_TICKS", lost_s, " without a request"
    )
    return (common, Group(f"Indicators of {name}", (lost,)))
