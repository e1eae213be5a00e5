"""What can go wrong with a machine, what sees it and how soon, and what remains."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from heatwright.generator.plan.adc import WRONG_TICKS
from heatwright.generator.plan.checks import PIN_HELD_TICKS
from heatwright.generator.plan.core import GATE_MAIN_PERMIT_TICKS
from heatwright.generator.plan.loop.current import FEWEST_STEPS, RULES_S
from heatwright.generator.plan.numbers import TICK_MS, quantity, steps
from heatwright.generator.plan.protection.limits import READINGS
from heatwright.generator.plan.protection.relay import CONTACT_TICKS
from heatwright.spec import Controller, Loop, proofs
from heatwright.spec.breakable import rules_of
from heatwright.spec.rules import Rule
from heatwright.spec.self_checks import FLASH_BYTES_A_TICK, read_back

TICK_S = TICK_MS / 1000
MAIN_PERMIT_S = GATE_MAIN_PERMIT_TICKS * TICK_S
CONTACT_S = CONTACT_TICKS * TICK_S
FLASH_ROUNDS = 2
"""A bit that flips behind the place that is looked at is seen in the round after."""


@dataclass(frozen=True)
class Hazard:
    """One cause, the rules that see it, and what no rule does about it.

    remains -- text, or a function of the controller that gives it; concerns -- whether the machine
    has what is meant, though no rule looks at it.
    """

    cause: str
    rules: tuple[str, ...]
    remains: str | Callable[[Controller], str]
    concerns: Callable[[Controller], bool] | None = None


def _dead_switch(controller: Controller) -> str:
    if controller.safety.relay is None:
        return "**The heat goes on**: only the thermal fuse ends it"
    if controller.safety.relay_feedback is None:
        return "a relay that has welded too, which nothing tells: the thermal fuse"
    return "a relay that welds in the same moment: the thermal fuse"


def _drift(controller: Controller) -> str:
    known = {rule.id for rule in rules_of(controller)}
    if "sensors_disagree" in known:
        return "what moves both sensors alike"
    if "effort_high" in known:
        return "less than the plant's tolerance hides: the machine gets hotter by as much"
    untold = "One that reads too low" if "effort_low" in known else "It"
    return f"**{untold} is told by nothing**: the machine gets hotter by as much"


def _has_fan(controller: Controller) -> bool:
    return any(loop.fan is not None for loop in controller.loops.values())


def _standing_fan(controller: Controller) -> str:
    if any(rule.id == "fan_stopped" for rule in rules_of(controller)):
        return "a fan that turns and moves no air: the fuse at the element"
    return "**Nothing proves that the fan turns**: the fuse at the element"


def _held_pin(controller: Controller) -> str:
    if controller.safety.relay is None:
        return "**one that is held at on heats on**: only the thermal fuse ends it"
    return "the relay's and a heater's pin at once: the thermal fuse"


def _wrong_clock(controller: Controller) -> str:
    if any(rule.id == "clock_wrong" for rule in rules_of(controller)):
        return "a clock that changes after the start, or by less than a quarter"
    return "**All times are longer by as much**, those of the rules, too"


HAZARDS = (
    Hazard(
        "A heater's switch conducts for ever",
        (
            "over_temperature",
            "runaway_above",
            "rising_while_off",
            "current_while_off",
            "over_current",
        ),
        _dead_switch,
    ),
    Hazard(
        "A heater's switch leaks",
        (
            "rising_while_off",
            "current_while_off",
            "effort_low",
            "runaway_above",
            "over_temperature",
        ),
        "a leak that heats by less than the rules ask for goes on",
    ),
    Hazard(
        "The safety relay's contact welds, or does not close",
        ("relay_welded", "relay_open"),
        "a mirror contact that has welded, too",
    ),
    Hazard(
        "The sensor falls out of its place",
        (
            "rise_rate",
            "heating_failed",
            "sensor_frozen",
            "effort_high",
            "runaway_below",
            "program_lags",
        ),
        "the heat given until then; one that is half out and still follows is not seen",
    ),
    Hazard(
        "The sensor drifts, creeps out of its place, or is of another kind",
        ("sensors_disagree", "effort_high", "effort_low"),
        _drift,
        lambda _: True,
    ),
    Hazard(
        "The reading stands still",
        ("sensor_frozen", "heating_failed", "runaway_below", "program_lags"),
        "one that stands at or above the setpoint: the heater is off then",
    ),
    Hazard("The sensor is torn, shorted, dead or disturbed", READINGS, "–"),
    Hazard(
        "The sensor jumps, or reads what cannot be",
        ("rise_rate", "over_temperature", "under_temperature"),
        "a reading that is wrong and moves plausibly: the machine gets hotter by as much",
    ),
    Hazard(
        "Heater, fuse, wire or supply is dead or weak",
        ("heating_failed", "runaway_below", "no_current", "effort_high", "program_lags"),
        "nothing that heats",
    ),
    Hazard(
        "Turns of the heater are shorted, or a wrong one is fitted",
        ("over_current", "over_temperature", "runaway_above"),
        "without a measured current the supply's own fuse",
    ),
    Hazard("A fan that a heater needs stands still", ("fan_stopped",), _standing_fan, _has_fan),
    Hazard(
        "A part that no loop controls gets too hot",
        ("monitor_limit",),
        "heat that comes from another source than the heaters",
    ),
    Hazard(
        "The program hangs",
        ("watchdog_reset",),
        "behind some bootloaders a hang with interrupts off is told as a plain reset",
    ),
    Hazard(
        "The controller's supply breaks down",
        ("brown_out", "settings_corrupt"),
        "a chip whose fuses leave its brown-out detector off",
    ),
    Hazard(
        "The processor leaves out work, or its stack grows into the variables",
        ("sequence_broken", "stack_overrun"),
        "a jump that leaves out no duty of a control step",
    ),
    Hazard(
        "A heater's or the relay's pin is shorted, or its driver in the chip is dead",
        ("pin_held",),
        _held_pin,
    ),
    Hazard(
        "The chip ages: a cell of RAM or EEPROM is stuck",
        ("ram_damaged", "eeprom_worn"),
        "cells that disturb others far away",
    ),
    Hazard(
        "The clock is off, or the watchdog does not reset any more",
        ("clock_wrong",),
        _wrong_clock,
        concerns=lambda _: True,
    ),
    Hazard(
        "The ADC or its reference is off",
        ("adc_wrong",),
        "less than a quarter; of an internal reference, what it shares with the chip's own voltage",
    ),
    Hazard(
        "A bit of RAM, flash or EEPROM flips, or the program came without its checksum",
        ("memory_damaged", "flash_damaged", "settings_corrupt", "flash_unsealed"),
        "bits that no check covers: heatwright's `docs/safety.md`",
    ),
    Hazard(
        "A door, an emergency stop or a cut-out opens, or its wire is torn",
        ("input_open",),
        "a contact that stays closed for ever, or a wire that is bridged",
    ),
    Hazard(
        "Nobody switches the heater off",
        ("on_too_long",),
        "what a machine without a limit of that time heats, it heats for ever",
    ),
    Hazard(
        "The host or the master is gone",
        ("master_lost",),
        "one that goes on asking and no longer thinks",
    ),
    Hazard(
        "The machine does what nobody wants, and somebody sees it",
        ("emergency_stop",),
        "a line that is torn: the mains switch",
    ),
)


@dataclass(frozen=True, slots=True)
class HazardRow:
    """A hazard of a controller: what sees it, and when; what remains."""

    cause: str
    seen: str
    remains: str


def hazards(controller: Controller) -> list[HazardRow]:
    """List the hazards that this controller has a rule for.

    A hazard without a rule is listed, too, where the controller has what it concerns.
    """
    known = {rule.id: rule for rule in rules_of(controller)}
    rows = []
    for hazard in HAZARDS:
        seen = [known[rule] for rule in hazard.rules if rule in known]
        if not seen and not (hazard.concerns and hazard.concerns(controller)):
            continue
        remains = hazard.remains
        rows.append(
            HazardRow(
                cause=hazard.cause,
                seen="; ".join(f"E{each.code:02d} {within(controller, each)}" for each in seen)
                or "nothing",
                remains=remains if isinstance(remains, str) else remains(controller),
            )
        )
    return rows


def within(controller: Controller, rule: Rule) -> str:
    """Say how long after its condition begins a rule has switched the heater off, at the latest."""
    if rule.id in {"brown_out", "settings_corrupt", "flash_unsealed", "clock_wrong"}:
        return "at the next start"
    slowest_s = max(_off_after(controller, name, rule.id) for name in controller.loops)
    told = quantity(round(slowest_s, 2), "s")
    if rule.id == "watchdog_reset":
        told += (
            f", with interrupts off the watchdog's {quantity(controller.safety.watchdog_s, 's')}"
        )
    return told


def _off_after(controller: Controller, name: str, rule: str) -> float:
    """Bound on that in a loop, s, as docs/safety.md derives it; of what lasts from its start on."""
    at_once = {
        "emergency_stop": TICK_S,
        "input_open": 2 * TICK_S,
        "watchdog_reset": MAIN_PERMIT_S + TICK_S,
        "sequence_broken": MAIN_PERMIT_S + TICK_S,
        "stack_overrun": 2 * TICK_S,
        "pin_held": (PIN_HELD_TICKS + 1) * TICK_S + _asked_within_s(controller),
        "eeprom_worn": 2 * TICK_S,
        "adc_wrong": WRONG_TICKS * TICK_S + 2 * TICK_S,
        "ram_damaged": controller.board.ram_bytes * TICK_S,
        "flash_damaged": FLASH_ROUNDS * controller.board.flash_bytes * TICK_S / FLASH_BYTES_A_TICK,
    }
    if rule in at_once:
        return at_once[rule]
    loop = controller.loops[name]
    lasts_s = _lasting(loop)
    if rule in lasts_s:
        ahead = 2 if rule == "sensor_frozen" else 1
        return loop.periods_s(steps(lasts_s[rule], loop) + ahead) + TICK_S
    return _waits(controller, loop).get(rule, 0.0) + loop.periods_s(2) + TICK_S


def _asked_within_s(controller: Controller) -> float:
    """How long it takes at most until a pin was asked often enough for the other level, s.

    Each window has a pulse and a pause, and both a step of the window at least.
    """
    asked_s = [0.0]
    for name in read_back(controller):
        output = controller.switches[name]
        if output.is_windowed:
            windows = math.ceil(PIN_HELD_TICKS * TICK_S / output.shortest_level_s)
            asked_s.append(windows * output.cycle_s)
    return max(asked_s)


def _lasting(loop: Loop) -> dict[str, float]:
    """How long the conditions of a loop's rules must last, s; counted in steps."""
    protection = loop.protection
    found = dict.fromkeys(READINGS, protection.stale_after_s)
    if protection.heating is not None:
        found["heating_failed"] = protection.heating.within_s
    if protection.frozen is not None:
        found["sensor_frozen"] = protection.frozen.for_s
    if protection.runaway is not None:
        found["runaway_above"] = found["runaway_below"] = protection.runaway.for_s
    if protection.agreement is not None:
        found["sensors_disagree"] = protection.agreement.for_s
    if protection.effort is not None:
        found["effort_high"] = found["effort_low"] = protection.effort.for_s
    if protection.on_for_at_most_s is not None:
        found["on_too_long"] = protection.on_for_at_most_s
    current_s = max(RULES_S, loop.periods_s(FEWEST_STEPS))
    return found | {"current_while_off": current_s, "no_current": current_s}


def _waits(controller: Controller, loop: Loop) -> dict[str, float]:
    """Time until a step can see it, s, for what is counted in ticks."""
    found = {"relay_welded": CONTACT_S, "relay_open": CONTACT_S}
    if loop.protection.master_lost_after_s is not None:
        found["master_lost"] = loop.protection.master_lost_after_s
    if controller.programs is not None and controller.programs.hold_back is not None:
        found["program_lags"] = controller.programs.hold_back.limit_s
    proven = proofs(controller)
    if loop.fan in proven:
        found["fan_stopped"] = proven[loop.fan].within_s
    return found
