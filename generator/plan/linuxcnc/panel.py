"""The PyVCP panel: its displays and buttons."""

from dataclasses import dataclass
from xml.sax.saxutils import escape

from heatwright.generator.plan.linuxcnc.names import controller_name, loop_names
from heatwright.generator.plan.source import Source
from heatwright.spec import Loop, facts_of

RESOLUTION_K = 1.0
"""Change of the setpoint per click on its arrow; its field also accepts tenths."""


@dataclass(frozen=True, slots=True)
class Light:
    """A bit of the register map, the word beside it, and its colour."""

    pin: str
    text: str
    color: str


LIGHTS = (
    Light("work", "WORK", "green"),
    Light("heat", "HEAT", "red"),
    Light("cool", "COOL", "deep sky blue"),
    Light("warm", "WARM", "yellow"),
    Light("valid", "SENSOR", "green"),
)


@dataclass(frozen=True, slots=True)
class PanelLoop:
    """A loop on the panel, with the ends of its bar and of its setpoint."""

    name: str
    title: str
    where: str
    current: bool
    cooler: bool
    lights: list[Light]
    least: str
    initial: str
    minimum: str
    maximum: str
    """The bar is green up to here, the highest setpoint."""
    limit: str
    """The bar is red from here on."""
    end: str
    resolution: str


@dataclass(frozen=True, slots=True)
class PanelRule:
    """A rule, with its text on the panel."""

    code: int
    text: str


@dataclass(frozen=True, slots=True)
class PanelNames:
    """The values for the panel's HAL and XML."""

    name: str
    file: str
    where: str
    title: str
    loops: list[PanelLoop]
    rules: list[PanelRule]


def panel_names(source: Source) -> PanelNames:
    """Compute the values for the panel's HAL and XML."""
    controller = source.controller
    identity = controller.identity
    return PanelNames(
        name=controller_name(controller),
        file=identity.name,
        where=source.where,
        title=_text(identity.title or identity.name),
        loops=[_loop(source, name, loop) for name, loop in controller.loops.items()],
        rules=[
            PanelRule(rule.code, _text(f"{rule.code}  {rule.display}"))
            for rule in facts_of(controller).rules
        ],
    )


def _loop(source: Source, name: str, loop: Loop) -> PanelLoop:
    setpoint, limit_c = loop.setpoint, loop.protection.maximum_c
    return PanelLoop(
        name=loop_names(source.controller)[name],
        title=_text(name),
        where=Source(source.spec, ("loops", name)).where,
        current=facts_of(source.controller, name).current is not None,
        cooler=loop.cooler is not None,
        lights=[light for light in LIGHTS if light.pin != "cool" or loop.cooler],
        least=_number(min(setpoint.minimum_c, 0.0)),
        initial=_number(setpoint.initial_c),
        minimum=_number(setpoint.minimum_c),
        maximum=_number(setpoint.maximum_c),
        limit=_number(limit_c),
        end=_number(limit_c + 0.1 * (limit_c - setpoint.minimum_c)),
        resolution=_number(RESOLUTION_K),
    )


def _number(value: float) -> str:
    return f"{value:.1f}"


def _text(text: str) -> str:
    """A string for PyVCP: a Python literal inside XML."""
    shown = "".join(each if each.isprintable() else "?" for each in text)
    quoted = shown.replace("\\", "\\\\").replace('"', '\\"')
    return escape(f'"{quoted}"')
