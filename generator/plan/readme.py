"""What the README of a project tells the one who builds the machine."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from heatwright.generator.plan.chips import fuses
from heatwright.generator.plan.core import FAULT_COOLING_ABOVE_C, rules
from heatwright.generator.plan.numbers import quantity
from heatwright.generator.plan.parts import Part
from heatwright.generator.plan.programs import in_words
from heatwright.generator.plan.text import markdown
from heatwright.generator.plan.uart import form
from heatwright.spec import LcdKeypad, Protection, SerialPlotter, Spec
from heatwright.spec.commands import gcode_of, modbus_of, nextion_of, starts_enabled


def readme_context(spec: Spec, parts: Iterable[Part]) -> dict[str, Any]:
    """Wiring, settings and fault codes."""
    controller = spec.controller
    identity = controller.identity
    return {
        "name": identity.name,
        "title": markdown(identity.title or identity.name),
        "digest": spec.digest,
        "board": identity.board,
        "clock_mhz": f"{controller.board.clock_hz / 1e6:g}",
        "fuses": fuses(controller.board),
        "wiring": list(dict.fromkeys(row for part in parts for row in part.wiring)),
        "loops": _loops(spec),
        "rules": [rule | {"limit": _limit(spec, str(rule["id"]))} for rule in rules(controller)],
        "keypad": any(isinstance(each, LcdKeypad) for each in controller.interfaces),
        "host": _host(spec),
        "modbus": _modbus(spec),
        "programs": in_words(controller),
        "touch": nextion_of(controller),
        "plotters": [
            each.baud for each in controller.interfaces if isinstance(each, SerialPlotter)
        ],
        "watchdog": quantity(controller.safety.watchdog_s, "s"),
    }


def _host(spec: Spec) -> dict[str, Any] | None:
    """What the host has to know; None if there is none."""
    gcode = gcode_of(spec.controller)
    if gcode is None:
        return None
    return {
        "baud": gcode.baud,
        "names": [
            {"address": address, "what": what, "name": name}
            for what, names in (
                ("loop", gcode.loops), ("fan", gcode.fans), ("stepper", gcode.steppers)
            )
            for address, name in names.items()
        ],
    }  # fmt: skip


def _modbus(spec: Spec) -> dict[str, Any] | None:
    """What the master has to know; None if there is none."""
    modbus = modbus_of(spec.controller)
    if modbus is None:
        return None
    return {
        "address": modbus.address,
        "form": f"{modbus.baud} baud, {form(modbus.parity, modbus.stop_bits)}",
        "linuxcnc": modbus.linuxcnc,
    }


def _loops(spec: Spec) -> list[dict[str, Any]]:
    return [
        {
            "name": name,
            "sensor": loop.sensor,
            "heater": loop.heater,
            "fan": loop.fan,
            "cooler": loop.cooler,
            "cooled_to": f"{FAULT_COOLING_ABOVE_C:g} °C",
            "disabled": not starts_enabled(spec.controller, name),
            "algorithm": loop.algorithm.kind,
            "period": quantity(loop.period_s, "s"),
            "initial": f"{loop.setpoint.initial_c:g} °C",
            "minimum": f"{loop.setpoint.minimum_c:g} °C",
            "maximum": f"{loop.setpoint.maximum_c:g} °C",
            "stored": loop.setpoint.stored,
        }
        for name, loop in spec.controller.loops.items()
    ]


def _limit(spec: Spec, rule: str) -> str:
    """What trips `rule`: once if all loops agree, else loop by loop."""
    loops = spec.controller.loops
    anywhere = _limits_of_the_controller(spec)
    if rule in anywhere:
        return anywhere[rule]
    limits = {
        name: (_limits(loop.protection) | _of_current(spec, loop.heater)).get(rule, "")
        for name, loop in loops.items()
    }
    if len(set(limits.values())) == 1:
        return next(iter(limits.values())) or "not used here"
    return "; ".join(f"{name}: {limit or 'not used'}" for name, limit in limits.items())


def _limits_of_the_controller(spec: Spec) -> dict[str, str]:
    """What trips the rules that belong to no loop, by the rule's id."""
    stop = {"emergency_stop": "`M112`"} if gcode_of(spec.controller) else {}
    return stop | {
        "watchdog_reset": f"a reset after {quantity(spec.controller.safety.watchdog_s, 's')} "
        "without the main loop",
        "brown_out": "a reset by the brown-out detector",
        "settings_corrupt": "records in the EEPROM, and none of them valid",
    }


def _of_current(spec: Spec, heater: str) -> dict[str, str]:
    """What trips the rules of a heater's current, by the rule's id."""
    current = getattr(spec.controller.outputs[heater], "current", None)
    if current is None:
        return {}
    return {
        "over_current": f"{quantity(current.over_a, 'A')} or more, in the mean",
        "current_while_off": "a current for half a second, or five steps, after it went off",
        "no_current": "less than half of the current that its duty must bring, for as long",
    }


def _limits(protection: Protection) -> dict[str, str]:
    """What trips each rule of a loop, by the rule's id; the readings' rules share one limit."""
    stale = f"no good reading for {quantity(protection.stale_after_s, 's')}"
    limits = {
        f"sensor_{cause}": stale
        for cause in ("no_answer", "short", "crc", "stale", "reset", "open", "range")
    } | {
        "over_temperature": f"{protection.maximum_c:g} °C or more",
        "under_temperature": f"{protection.minimum_c:g} °C or less",
        "rise_rate": f"a change of more than {quantity(protection.rise_rate_k_per_s, 'K/s')}",
    }
    if protection.frozen is not None:
        limits["sensor_frozen"] = (
            f"one and the same reading for {quantity(protection.frozen.for_s, 's')} of heat "
            "below the setpoint"
        )
    if protection.master_lost_after_s is not None:
        silence = quantity(protection.master_lost_after_s, "s")
        limits["master_lost"] = f"no request for {silence} while the loop is enabled"
    if protection.heating is not None:
        limits["heating_failed"] = (
            f"less than {quantity(protection.heating.rise_k, 'K')} in "
            f"{quantity(protection.heating.within_s, 's')} of full heat"
        )
    if protection.runaway is not None:
        time = quantity(protection.runaway.for_s, "s")
        limits["runaway_above"] = (
            f"{quantity(protection.runaway.above_k, 'K')} above the setpoint for {time}"
        )
        if protection.runaway.below_k is not None:
            limits["runaway_below"] = (
                f"{quantity(protection.runaway.below_k, 'K')} below the setpoint for {time}"
            )
    if protection.rising_while_off is not None:
        rising = protection.rising_while_off
        limits["rising_while_off"] = (
            f"a rise of {quantity(rising.rise_k, 'K')}, "
            f"from {quantity(rising.settle_s, 's')} after switching off"
        )
    if protection.master_lost_after_s is not None:
        lost = quantity(protection.master_lost_after_s, "s")
        limits["master_lost"] = f"no request for {lost} while the loop is enabled"
    return limits
