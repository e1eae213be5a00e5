"""Monitors: sensors of no loop, their limits, and their display."""

from dataclasses import dataclass

from heatwright.generator.plan.numbers import quantity
from heatwright.generator.plan.parts import Call, Constant, File, Group, Part, Stage, pair
from heatwright.generator.plan.sensors.common import raw_type
from heatwright.generator.plan.source import Source
from heatwright.spec import Loop, Monitor, facts_of

MOST_TURN_STEPS = 128
TURN_S = 2.0
"""Shortest time, s, for which a display of two lines shows the warning before its other text."""


@dataclass(frozen=True, slots=True)
class MonitorNames:
    """The values for the templates of a monitor, in addition to its name."""

    sensor: str
    raw: str
    loop: str
    warning_where: str
    limit_where: str
    stale_where: str


@dataclass(frozen=True, slots=True)
class MonitorsNames:
    """The values for the templates that show monitors."""

    where: str
    monitors: list[str]
    loop_name: str = ""
    """The loop whose display also shows the monitors."""


def plan_monitors(root: Source, loop_name: str, loop: Loop) -> Part:
    """Plan the monitors that are checked in the steps of a loop."""
    found = facts_of(root.controller, loop_name).monitored
    return Part(
        files=tuple(
            file for name, each in found.items() for file in _files(root, name, each, loop_name)
        ),
        groups=tuple(
            Group(f"Monitor {name}", _constants(root.at("monitors", name), name, each, loop))
            for name, each in found.items()
        ),
        start_calls=tuple(
            Call(Stage.CONTROL, f"sensor_{each.sensor}.h", f"sensor_{each.sensor}_begin();")
            for each in found.values()
        ),
    )


def _files(root: Source, name: str, monitor: Monitor, loop_name: str) -> tuple[File, ...]:
    at = root.at("monitors", name)
    own = MonitorNames(
        sensor=monitor.sensor,
        raw=raw_type(root.controller.thermometers[monitor.sensor]),
        loop=loop_name,
        warning_where=at.at("warning").where,
        limit_where=at.at("limit").where,
        stale_where=at.at("stale_after").where,
    )
    return pair(f"monitor_{name}", "protection/monitor", (at.named(name), own))


def _constants(at: Source, name: str, monitor: Monitor, loop: Loop) -> tuple[Constant, ...]:
    prefix = f"MONITOR_{name.upper()}"
    ends_c = monitor.warning_c - monitor.hysteresis_k
    return (
        at.at("warning").given(f"{prefix}_WARNING_C", monitor.warning_c, "degC"),
        at.at("hysteresis").number(
            f"{prefix}_WARNING_END_C", ends_c, f"{quantity(monitor.hysteresis_k, 'K')} below it"
        ),
        at.at("limit").given(f"{prefix}_LIMIT_C", monitor.limit_c, "degC"),
        at.at("stale_after").steps(f"{prefix}_STALE_STEPS", monitor.stale_after_s, loop),
    )


def told(root: Source) -> tuple[File, ...]:
    """Plan the functions by which interfaces read the monitors; none if there are no monitors."""
    names = list(root.controller.monitors)
    if not names:
        return ()
    context = MonitorsNames(root.at("monitors").where, names)
    return pair("monitors", "protection/monitors", context, plain_header=True)


def shown(root: Source, loop_name: str) -> tuple[tuple[File, ...], tuple[Constant, ...]]:
    """Plan the warning on a display of two lines that shows a loop."""
    if not root.controller.monitors:
        return (), ()
    context = MonitorsNames(root.at("monitors").where, list(root.controller.monitors), loop_name)
    loop, turn = root.controller.loops[loop_name], 1
    while loop.periods_s(turn) < TURN_S and turn < MOST_TURN_STEPS:
        turn *= 2
    return (
        *told(root),
        *pair("monitors_shown", "interfaces/monitors_shown", context, plain_header=True),
    ), (Constant("PANEL_WARNING_STEPS", f"{turn}u", "a warning and the setpoint take turns"),)
