"""The PyVCP panel: what is shown and what can be pressed."""

from __future__ import annotations

from typing import Any
from xml.sax.saxutils import escape

from heatwright.generator.plan.linuxcnc.names import controller_name, loop_names
from heatwright.generator.plan.sensors.common import current_sensor
from heatwright.generator.plan.source import Source
from heatwright.spec import Loop
from heatwright.spec.breakable import rules_of

RESOLUTION_K = 1.0
"""A click on an arrow of the setpoint; its field takes tenths."""

LIGHTS = (
    {"pin": "work", "text": "WORK", "color": "green"},
    {"pin": "heat", "text": "HEAT", "color": "red"},
    {"pin": "cool", "text": "COOL", "color": "deep sky blue"},
    {"pin": "warm", "text": "WARM", "color": "yellow"},
    {"pin": "valid", "text": "SENSOR", "color": "green"},
)
"""Names of bits in the register map, the words beside them, and the colour that each has."""


def panel_context(source: Source) -> dict[str, Any]:
    """All that the panel's HAL and XML need to know."""
    controller = source.controller
    identity, names = controller.identity, loop_names(controller)
    return {
        "name": controller_name(controller),
        "file": identity.name,
        "where": source.where,
        "title": _text(identity.title or identity.name),
        "loops": [
            {
                "name": names[name],
                "title": _text(name),
                "where": Source(source.spec, ("loops", name)).where,
                "current": current_sensor(controller, loop) is not None,
                "cooler": loop.cooler is not None,
                "lights": [light for light in LIGHTS if light["pin"] != "cool" or loop.cooler],
                **_scale(loop),
            }
            for name, loop in controller.loops.items()
        ],
        "rules": [
            {"code": rule.code, "text": _text(f"{rule.code}  {rule.display}")}
            for rule in rules_of(controller)
        ],
    }


def _scale(loop: Loop) -> dict[str, str]:
    """Ends of the bar and of the setpoint: green to the highest setpoint, red from the limit."""
    setpoint, protection = loop.setpoint, loop.protection
    return {
        "least": _number(min(setpoint.minimum_c, 0.0)),
        "initial": _number(setpoint.initial_c),
        "minimum": _number(setpoint.minimum_c),
        "maximum": _number(setpoint.maximum_c),
        "limit": _number(protection.maximum_c),
        "end": _number(protection.maximum_c + 0.1 * (protection.maximum_c - setpoint.minimum_c)),
        "resolution": _number(RESOLUTION_K),
    }


def _number(value: float) -> str:
    return f"{value:.1f}"


def _text(text: str) -> str:
    """A string as PyVCP reads it: Python's, inside XML."""
    shown = "".join(each if each.isprintable() else "?" for each in text)
    quoted = shown.replace("\\", "\\\\").replace('"', '\\"')
    return escape(f'"{quoted}"')
