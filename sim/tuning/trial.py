"""Try gains on the bench: the whole control law, with its limits, on the spec's machine."""

from collections.abc import Callable

from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.trace import Trace
from heatwright.sim.tuning.gains import Gains
from heatwright.sim.tuning.orders import heat
from heatwright.spec import Controller, Event, Pid, facts_of, must_release

Progress = Callable[[float, float], None]


def with_gains(controller: Controller, loop: str, gains: Gains) -> Controller:
    """Replace a loop's gains; an on-off loop becomes a PID."""
    spec = controller.loops[loop]
    changes = {
        "kp": gains.kp,
        "ki": gains.ki,
        "kd": gains.kd,
        "derivative_filter_s": gains.filter_s if gains.kd else 0.0,
    }
    whole = spec.algorithm.pid or Pid.model_validate({"kind": "pid", "kp": 0.0})
    changed = spec.model_copy(update={"algorithm": whole.model_copy(update=changes)})
    return controller.with_loop(loop, changed).model_copy(update={"comparison": ()})


def try_gains(  # noqa: PLR0913 - all but two are names
    controller: Controller,
    loop: str,
    gains: Gains,
    *,
    target_c: float,
    length_s: float,
    progress: Progress | None = None,
) -> Trace:
    """Return the trace of a loop that heats from cold to a temperature and holds it."""
    tuned = at_setpoint(with_gains(controller, loop, gains), loop, target_c)
    scenario = (*heat(tuned, loop, target_c), ending(length_s))
    return bench(tuned, ReferenceDevice(tuned), scenario, progress=progress)


def at_setpoint(controller: Controller, loop: str, target_c: float) -> Controller:
    """Let a loop without host or master start on, with this setpoint."""
    spec = controller.loops[loop]
    if must_release(controller) or facts_of(controller, loop).hosted:
        return controller
    setpoint = spec.setpoint.model_copy(update={"initial_c": target_c, "stored": False})
    changed = spec.model_copy(update={"setpoint": setpoint, "starts": "enabled"})
    return controller.with_loop(loop, changed)


def ending(length_s: float) -> Event:
    """Return the event that ends a scenario at `length_s`."""
    return Event.model_validate({"for": f"{length_s!r} s"})
