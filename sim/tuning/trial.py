"""Gains tried on the bench: the whole control law, with its limits, against the spec's machine."""

from __future__ import annotations

from collections.abc import Callable

from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.trace import Trace
from heatwright.sim.tuning.gains import Gains
from heatwright.spec import Controller, Event, Pid
from heatwright.spec.base import ReadOnlyDict
from heatwright.spec.commands import gcode_of

Progress = Callable[[float, float], None]

COMMAND_S = 1.0
"""When a host asks for the temperature; a controller without one asks for it from the start."""


def with_gains(controller: Controller, loop: str, gains: Gains) -> Controller:
    """Put gains in the place of a loop's own; an on-off loop becomes a PID."""
    spec = controller.loops[loop]
    changes = {
        "kp": gains.kp,
        "ki": gains.ki,
        "kd": gains.kd,
        "derivative_filter_s": gains.filter_s if gains.kd else 0.0,
    }
    whole = spec.algorithm if isinstance(spec.algorithm, Pid) else blank_pid()
    changed = spec.model_copy(update={"algorithm": whole.model_copy(update=changes)})
    loops = ReadOnlyDict({**controller.loops, loop: changed})
    return controller.model_copy(update={"loops": loops, "comparison": ()})


def blank_pid() -> Pid:
    """Return a PID with the defaults of the language."""
    return Pid.model_validate({"kind": "pid", "kp": 0.0})


def try_gains(  # noqa: PLR0913 - all but two are names
    controller: Controller,
    loop: str,
    gains: Gains,
    *,
    target_c: float,
    length_s: float,
    progress: Progress | None = None,
) -> Trace:
    """Heat from cold to a temperature and hold it."""
    tuned = at_setpoint(with_gains(controller, loop, gains), loop, target_c)
    scenario = (*asking(tuned, loop, f"M104 {{}} S{target_c:g}"), ending(length_s))
    return bench(tuned, ReferenceDevice(tuned), scenario, progress=progress)


def at_setpoint(controller: Controller, loop: str, target_c: float) -> Controller:
    """Let a loop that no host commands start with a setpoint."""
    spec = controller.loops[loop]
    if gcode_of(controller) is not None:
        return controller
    setpoint = spec.setpoint.model_copy(update={"initial_c": target_c, "stored": False})
    changed = spec.model_copy(update={"setpoint": setpoint})
    return controller.model_copy(
        update={"loops": ReadOnlyDict({**controller.loops, loop: changed})}
    )


def asking(controller: Controller, loop: str, line: str) -> tuple[Event, ...]:
    """Have the host send a line, with the loop's tool at `{}`; nothing where there is no host."""
    gcode = gcode_of(controller)
    if gcode is None:
        return ()
    tool = next(name for name, served in gcode.loops.items() if served == loop)
    return (Event.model_validate({"at": f"{COMMAND_S!r} s", "send": line.format(tool)}),)


def ending(length_s: float) -> Event:
    """Return the end of a scenario."""
    return Event.model_validate({"for": f"{length_s!r} s"})
