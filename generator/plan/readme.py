"""What the README of a project tells the one who builds the machine."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from heatwright.generator.plan.chips import fuses
from heatwright.generator.plan.commissioning import commissioning
from heatwright.generator.plan.core import FAULT_COOLING_ABOVE_C, lockout_ends
from heatwright.generator.plan.lines import lines
from heatwright.generator.plan.numbers import quantity
from heatwright.generator.plan.parts import Part, Wiring
from heatwright.generator.plan.programs.programs import in_words
from heatwright.generator.plan.protection.hazards import hazards
from heatwright.generator.plan.protection.limits import limit
from heatwright.generator.plan.text import markdown
from heatwright.generator.plan.uart import form
from heatwright.spec import Controller, SerialPlotter, Spec
from heatwright.spec.adjusted import numbers_of
from heatwright.spec.breakable import rules_of
from heatwright.spec.commands import (
    gcode_of,
    keypad_of,
    lockout_of,
    modbus_of,
    nextion_of,
    placed,
)
from heatwright.spec.facts import facts_of
from heatwright.spec.self_checks import proves_watchdog, self_checked
from heatwright.spec.sensing.budget import budgets


def readme_context(spec: Spec, parts: Iterable[Part]) -> dict[str, Any]:
    """Wiring, settings and fault codes."""
    controller = spec.controller
    identity, wiring = controller.identity, wiring_of(parts)
    return {
        "name": identity.name,
        "title": markdown(identity.title or identity.name),
        "digest": spec.digest,
        "board": identity.board,
        "clock_mhz": f"{controller.board.clock_hz / 1e6:g}",
        "sealed": self_checked(controller),
        "proves": proves_watchdog(controller),
        "fuses": fuses(controller.board),
        "wiring": wiring,
        "commissioning": commissioning(controller, wiring),
        "lines": lines(controller),
        "loops": _loops(spec),
        "budgets": [{"name": name, "found": found} for name, found in budgets(controller)],
        "rules": [(rule, limit(spec, rule.id)) for rule in rules_of(controller)],
        "hazards": hazards(controller),
        "relay": controller.safety.relay,
        "cooled": any(loop.cooler for loop in controller.loops.values()),
        "countdown": _countdown(controller),
        "numbers": _numbers(controller),
        "keypad": keypad_of(controller) is not None,
        "menu": any(
            facts_of(controller, name).keyed and facts_of(controller, name).programmed
            for name in controller.loops
        ),
        "host": _host(spec),
        "modbus": _modbus(spec),
        "programs": in_words(controller),
        "touch": nextion_of(controller),
        "plotters": [each.baud for each in placed(controller, SerialPlotter).values()],
        "lockout": _lockout(controller),
        "watchdog": quantity(controller.safety.watchdog_s, "s"),
    }


def wiring_of(parts: Iterable[Part]) -> list[Wiring]:
    """List what is at which pin, each once."""
    return list(dict.fromkeys(row for part in parts for row in part.wiring))


def _lockout(controller: Controller) -> dict[str, object] | None:
    """What repeated trips lead to."""
    lockout = lockout_of(controller)
    if lockout is None:
        return None
    return {
        "trips": lockout.trips,
        "within": quantity(lockout.within_s, "s"),
        "ends": lockout_ends(controller),
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


def _numbers(controller: Controller) -> list[str]:
    """Say between which ends keys set which numbers."""
    keypad = keypad_of(controller)
    return [
        f"{each.kind.key} from {each.minimum:g} to {quantity(each.maximum, each.kind.unit)}"
        for each in (numbers_of(controller, keypad.loop) if keypad else ())
    ]


def _countdown(controller: Controller) -> str | None:
    """Say from when the time set by keys counts; None if none can be set."""
    keypad = keypad_of(controller)
    if keypad is None or keypad.countdown is None:
        return None
    if keypad.countdown.counts == "at once":
        return "while the loop is on"
    return "from the moment on in which the setpoint is reached"


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
            "disabled": not facts_of(spec.controller, name).starts_enabled,
            "algorithm": loop.algorithm.kind,
            "period": quantity(loop.period_s, "s"),
            "initial": f"{loop.setpoint.initial_c:g} °C",
            "minimum": f"{loop.setpoint.minimum_c:g} °C",
            "maximum": f"{loop.setpoint.maximum_c:g} °C",
            "stored": loop.setpoint.stored,
        }
        for name, loop in spec.controller.loops.items()
    ]
