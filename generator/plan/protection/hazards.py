"""The hazards of a machine: the rules that detect each, how soon, and the remaining risk."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from heatwright.generator.plan.adc import WRONG_TICKS
from heatwright.generator.plan.checks import PIN_HELD_TICKS
from heatwright.generator.plan.core import GATE_MAIN_PERMIT_TICKS
from heatwright.generator.plan.loop.current import FEWEST_STEPS, RULES_S
from heatwright.generator.plan.numbers import TICK_MS, quantity, steps
from heatwright.generator.plan.protection.limits import READINGS
from heatwright.generator.plan.protection.relay import CONTACT_TICKS
from heatwright.spec import Controller, Loop, Rule, facts_of
from heatwright.spec.physics.effort import high_trips_up_to_c
from heatwright.spec.self_checks import FLASH_BYTES_A_TICK

TICK_S = TICK_MS / 1000
MAIN_PERMIT_S = GATE_MAIN_PERMIT_TICKS * TICK_S
CONTACT_S = CONTACT_TICKS * TICK_S
FLASH_ROUNDS = 2
"""Rounds until a flipped bit is found: it may flip just after the present round has checked it."""


@dataclass(frozen=True)
class Hazard:
    """One cause, the rules that detect it, and the risk that remains.

    remains -- the risk, or a function that gives it for a controller; concerns -- whether a
    controller without these rules has the hazard.
    """

    cause: str
    rules: tuple[str, ...]
    remains: str | Callable[[Controller], str]
    concerns: Callable[[Controller], bool] | None = None


def _dead_switch(controller: Controller) -> str:
    if controller.safety.relay is None:
        return "**The heater stays on**: only the thermal fuse switches it off"
    if controller.safety.relay_feedback is None:
        return "a relay that is welded too, which no rule detects: the thermal fuse"
    return "a relay that welds at the same time: the thermal fuse"


def _drift(controller: Controller) -> str:
    known = {rule.id for rule in facts_of(controller).rules}
    if all(loop.protection.agreement is not None for loop in controller.loops.values()):
        return "a cause that shifts both sensors alike"
    if "effort_high" in known or "sensors_disagree" in known:
        hidden = "an error within the plant's tolerance: the machine gets hotter by this error"
        return "; ".join((hidden, *_undetected(controller)))
    untold = "a reading that is too low" if "effort_low" in known else "it"
    return f"**No rule detects {untold}**: the machine gets hotter by the error"


def _undetected(controller: Controller) -> Iterator[str]:
    """Name the loops whose setpoints go beyond the readings at which effort_high can trip."""
    for name, loop in controller.loops.items():
        if loop.protection.agreement is not None:
            continue
        end_c = high_trips_up_to_c(loop)
        if end_c is None or end_c < loop.setpoint.maximum_c:
            above = "" if end_c is None else f" above {end_c} °C"
            yield f"**of {name}{above} no rule detects a reading that is too low**"


def _has_fan(controller: Controller) -> bool:
    return any(loop.fan is not None for loop in controller.loops.values())


def _standing_fan(controller: Controller) -> str:
    if any(rule.id == "fan_stopped" for rule in facts_of(controller).rules):
        return "a fan that turns but moves no air: the thermal fuse at the element"
    return "**No signal shows that the fan turns**: the thermal fuse at the element"


def _held_pin(controller: Controller) -> str:
    heaters = (controller.switches[loop.heater] for loop in controller.loops.values())
    when = "; a pin under pulse width is read only while its duty is 0 or full"
    pulsed = when if any(heater.frequency_hz for heater in heaters) else ""
    if controller.safety.relay is None:
        return f"**a pin stuck at on keeps heating**: only the thermal fuse ends it{pulsed}"
    return f"the relay's and a heater's pin at the same time: the thermal fuse{pulsed}"


def _wrong_clock(controller: Controller) -> str:
    if any(rule.id == "clock_wrong" for rule in facts_of(controller).rules):
        return "a clock that changes after the start, or by less than a quarter"
    return "**All times are wrong by as much**, also those of the rules"


HAZARDS = (
    Hazard(
        "A heater's switch conducts permanently",
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
        "a leak that heats too little to trip a rule",
    ),
    Hazard(
        "The safety relay's contact welds, or does not close",
        ("relay_welded", "relay_open"),
        "a mirror contact that is welded, too",
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
        "the heat given until then; a sensor that is half out and still follows is not detected",
    ),
    Hazard(
        "The sensor drifts, creeps out of its place, or is of another kind",
        ("sensors_disagree", "effort_high", "effort_low"),
        _drift,
        lambda _: True,
    ),
    Hazard(
        "The reading is stuck",
        ("sensor_frozen", "heating_failed", "runaway_below", "program_lags"),
        "a reading that is stuck at or above the setpoint: then the heater is off",
    ),
    Hazard("The sensor is torn, shorted, dead or disturbed", READINGS, "–"),
    Hazard(
        "The reading jumps, or is impossible",
        ("rise_rate", "over_temperature", "under_temperature"),
        "a wrong reading that moves plausibly: the machine gets hotter by the error",
    ),
    Hazard(
        "Heater, fuse, wire or supply is dead or weak",
        ("heating_failed", "runaway_below", "no_current", "effort_high", "program_lags"),
        "no heat: no danger",
    ),
    Hazard(
        "Turns of the heater are shorted, or a wrong heater is fitted",
        ("over_current", "over_temperature", "runaway_above"),
        "without a measured current: the supply's own fuse",
    ),
    Hazard("A fan that a heater needs stands still", ("fan_stopped",), _standing_fan, _has_fan),
    Hazard(
        "A part that no loop controls gets too hot",
        ("monitor_limit",),
        "heat from another source than the heaters",
    ),
    Hazard(
        "The program hangs",
        ("watchdog_reset",),
        "with some boot loaders, a hang with interrupts off is reported as a plain reset",
    ),
    Hazard(
        "The controller's supply breaks down",
        ("brown_out", "settings_corrupt"),
        "a chip whose fuses leave the brown-out detector off",
    ),
    Hazard(
        "The processor skips work, or its stack grows into the variables",
        ("sequence_broken", "stack_overrun"),
        "a jump that skips no task of a control step",
    ),
    Hazard(
        "A heater's or the relay's pin is shorted, or its driver in the chip is dead",
        ("pin_held",),
        _held_pin,
    ),
    Hazard(
        "The chip ages: a cell of RAM or EEPROM is stuck",
        ("ram_damaged", "eeprom_worn"),
        "cells that disturb distant cells",
    ),
    Hazard(
        "The clock is wrong, or the watchdog no longer resets",
        ("clock_wrong",),
        _wrong_clock,
        concerns=lambda _: True,
    ),
    Hazard(
        "The ADC or its reference is wrong",
        ("adc_wrong",),
        "an error below a quarter, or of the reference and the measured voltage by the same share",
    ),
    Hazard(
        "A bit of RAM, flash or EEPROM flips, or the program has no checksum",
        ("memory_damaged", "flash_damaged", "settings_corrupt", "flash_unsealed"),
        "bits that no check covers: heatwright's `docs/safety.md`",
    ),
    Hazard(
        "A door, an emergency stop or a cut-out opens, or its wire is torn",
        ("input_open",),
        "a contact that stays closed permanently, or a wire that is bridged",
    ),
    Hazard(
        "Nobody switches the heater off",
        ("on_too_long",),
        "without a limit of that time the machine heats permanently",
    ),
    Hazard(
        "The host or the master is lost",
        ("master_lost",),
        "a host or master that hangs but keeps sending requests",
    ),
    Hazard(
        "The operator sees the machine do something wrong",
        ("emergency_stop",),
        "a broken line to the host: the mains switch",
    ),
)


@dataclass(frozen=True, slots=True)
class HazardRow:
    """A hazard of a controller: the rules that detect it, how soon, and the remaining risk."""

    cause: str
    seen: str
    remains: str


def hazards(controller: Controller) -> list[HazardRow]:
    """List the hazards that a rule of this controller detects.

    A hazard without a rule is also listed, if it concerns this controller.
    """
    known = {rule.id: rule for rule in facts_of(controller).rules}
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
    """Return the longest time from the start of a rule's condition until the heater is off."""
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
    """Upper bound, s, of the time that `within` returns, for one loop and a lasting condition."""
    at_once = {
        "emergency_stop": TICK_S,
        "input_open": 2 * TICK_S,
        "watchdog_reset": MAIN_PERMIT_S + TICK_S,
        "sequence_broken": MAIN_PERMIT_S + TICK_S,
        "stack_overrun": 2 * TICK_S,
        "pin_held": (PIN_HELD_TICKS + 1) * TICK_S + _pulsed_within_s(controller),
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
        further = 2 if rule == "sensor_frozen" else 1
        return loop.periods_s(steps(lasts_s[rule], loop) + further) + TICK_S
    return _waits(controller, loop).get(rule, 0.0) + loop.periods_s(2) + TICK_S


def _pulsed_within_s(controller: Controller) -> float:
    """Longest time until a pin was driven to the other level often enough for rule pin_held, s.

    Each window has a pulse and a pause; each lasts at least one step of the window.
    """
    found_s = [0.0]
    for name in facts_of(controller).read_back:
        output = controller.switches[name]
        if output.is_windowed:
            windows = math.ceil(PIN_HELD_TICKS * TICK_S / output.shortest_level_s)
            found_s.append(windows * output.cycle_s)
    return max(found_s)


def _lasting(loop: Loop) -> dict[str, float]:
    """How long the conditions of a loop's rules must last before they trip, s; counted in steps."""
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
    """Time that other rules of a loop count before a control step can trip them, s."""
    found = {"relay_welded": CONTACT_S, "relay_open": CONTACT_S}
    if loop.protection.master_lost_after_s is not None:
        found["master_lost"] = loop.protection.master_lost_after_s
    if controller.programs is not None and controller.programs.hold_back is not None:
        found["program_lags"] = controller.programs.hold_back.limit_s
    proven = facts_of(controller).proofs
    if loop.fan is not None and loop.fan in proven:
        found["fan_stopped"] = proven[loop.fan].within_s
    return found
