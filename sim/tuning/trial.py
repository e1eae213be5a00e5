"""Try gains on the bench, or the firmware's autotune: the whole control law on a machine."""

from collections.abc import Callable

from heatwright.sim.bench import Progress, ReferenceDevice, bench
from heatwright.sim.interfaces.gcode import heats, tunes
from heatwright.sim.plots.plot_data import fault_label, faults
from heatwright.sim.trace import Trace
from heatwright.sim.tuning.gains import Gains
from heatwright.spec import Controller, Event, Pid, facts_of


def with_gains(controller: Controller, loop: str, gains: Gains) -> Controller:
    """Return a controller with other gains for a loop; an on-off loop becomes a PID."""
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
    """Return a controller whose loop, if nobody commands it, starts on at this setpoint."""
    spec = controller.loops[loop]
    facts = facts_of(controller, loop)
    if facts.must_release or facts.hosted:
        return controller
    setpoint = spec.setpoint.model_copy(update={"initial_c": target_c, "stored": False})
    changed = spec.model_copy(update={"setpoint": setpoint, "starts": "enabled"})
    return controller.with_loop(loop, changed)


def ending(length_s: float) -> Event:
    """Return the event that ends a scenario at `length_s`."""
    return Event.model_validate({"for": f"{length_s!r} s"})


ORDER_S = 1.0
"""Time of the command; a loop that is not commanded starts on its own."""


def heat(controller: Controller, loop: str, target_c: float) -> tuple[Event, ...]:
    """Return the events that heat a loop to a temperature, °C; none if it is not commanded."""
    if facts_of(controller).modbus is not None:
        return (_written({f"{loop}.setpoint": f"{target_c!r} °C", f"{loop}.enabled": True}),)
    return _sent(controller, loop, heats, f"S{target_c:g}")


def tune(controller: Controller, loop: str, target_c: float, cycles: int) -> tuple[Event, ...]:
    """Return the events that tune a loop at a temperature, °C; a master cannot set the cycles."""
    if facts_of(controller).modbus is not None:
        orders = {f"{loop}.setpoint": f"{target_c!r} °C", f"{loop}.enabled": True}
        return (_written({**orders, f"{loop}.tune": True}),)
    return _sent(controller, loop, tunes, f"S{target_c:g} C{cycles}")


def _sent(
    controller: Controller, loop: str, command: Callable[[str], str], words: str
) -> tuple[Event, ...]:
    """Return the event with a command, which depends on the host's address of the loop."""
    gcode = facts_of(controller).gcode
    called = [name for name, served in gcode.loops.items() if served == loop] if gcode else []
    if not called:
        return ()
    line = f"{command(called[0])} {words}"
    return (Event.model_validate({"at": f"{ORDER_S!r} s", "send": line}),)


def _written(values: dict[str, object]) -> Event:
    return Event.model_validate({"at": f"{ORDER_S!r} s", "write": values})


DONE = 2
RESULTS = {
    1: "it did not come to an end",
    3: "it took longer than its time-out",
    4: "it was stopped",
    5: "the machine became too hot",
    6: "its results are not usable",
}
"""Why there are no gains, by autotune.result (docs/control.md, "Autotune")."""

AFTERWARDS_S = 10.0
"""Time after the time-out within which the result must be there."""


class TuningFailed(Exception):
    """The experiment found no gains; the text says why."""


def relay(
    controller: Controller, loop: str, target_c: float, progress: Progress | None = None
) -> Gains:
    """Run the relay experiment from cold, as the firmware does, and return its gains.

    Raises TuningFailed: a protection tripped, or the experiment found nothing.
    """
    spec = controller.loops[loop]
    pid = spec.algorithm.pid
    assert pid is not None  # noqa: S101 - the checks ensure it
    assert spec.autotune is not None  # noqa: S101 - the caller has checked it
    length_s = spec.autotune.timeout_s + AFTERWARDS_S
    scenario = (*tune(controller, loop, target_c, spec.autotune.cycles), ending(length_s))
    trace = bench(controller, ReferenceDevice(controller), scenario, progress=progress)
    log = trace.steps[loop]
    for _, code in faults(log):
        raise TuningFailed(f"{fault_label(code)} tripped")
    last = log[-1]
    result = int(last["autotune.result"])
    if result != DONE:
        raise TuningFailed(RESULTS.get(result, "it did not start"))
    kp, ki, kd = (float(last[f"autotune.{name}"]) for name in ("kp", "ki", "kd"))
    least, most = (float(last[f"autotune.integral_{end}"]) for end in ("minimum", "maximum"))
    return Gains(kp, ki, kd, pid.derivative_filter_s, (least, most))
