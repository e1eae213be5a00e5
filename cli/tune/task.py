"""What is to be tuned, from the spec and the options."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from heatwright.cli.ends import Refused
from heatwright.cli.tune.methods import Task
from heatwright.sim.tuning.process import Process, power_of, process_of
from heatwright.sim.tuning.rules import model_for
from heatwright.spec import Controller, DigitalOutput, Loop, Pid, Spec
from heatwright.spec.commands import tunable
from heatwright.spec.quantity import about, celsius

LONGEST_S = 48 * 3600.0
"""Of heating up; a machine that takes longer has a slip of the pen in its plant."""

FILTER_SHARE = 10.0
"""A derivative without a filter of its own gets a tenth of what it must lead (Åström & Hägglund,
Advanced PID Control, 2006, section 3.3: two to twenty)."""

_ASKED = re.compile(r"M10[49]\b.*?\bS(\d+(?:\.\d+)?)")


def task_of(
    spec: Spec,
    loop: str | None,
    *,
    at_c: float | None,
    lambda_s: float | None,
    tauc_s: float | None,
) -> Task:
    """Join spec and options.

    Raises Refused where there is nothing to tune.
    """
    controller = spec.controller
    name = loop or next(iter(controller.loops))
    if name not in controller.loops:
        able = ", ".join(controller.loops)
        raise Refused(f"{spec.file_name}: has no loop {name}; there are {able}.")
    chosen = controller.loops[name]
    _check_output(spec, name, chosen)
    if controller.simulation is None:
        raise Refused(
            f"{spec.file_name}: has no `simulation`, so there is no machine to tune for. Describe "
            "one, or let `heatwright identify` find it in a record."
        )
    target_c = _target(spec, name) if at_c is None else _within(chosen, at_c)
    process = process_of(controller, name, target_c)
    warm_s = _warm_s(spec, process, chosen, target_c)
    return Task(
        controller, name, target_c, process, warm_s, _filter_s(process, chosen), lambda_s, tauc_s
    )


def relay_is_possible(controller: Controller, loop: str) -> bool:
    """Tell whether the loop's firmware can tune itself."""
    spec = controller.loops[loop]
    return spec.autotune is not None and tunable(controller, loop) and len(controller.loops) == 1


def methods_of(task: Task, asked: Sequence[str], every: Sequence[str]) -> tuple[str, ...]:
    """Return the methods to do: those asked for, or all that the spec allows."""
    possible = relay_is_possible(task.controller, task.loop)
    if "relay" in asked and not possible:
        raise Refused(
            f"Loop {task.loop} does not tune itself: the relay needs `autotune: {{}}` in the loop, "
            "the algorithm pid, and an interface gcode or modbus_rtu that serves it (one loop)."
        )
    wanted = asked or every
    return tuple(method for method in every if method in wanted and (possible or method != "relay"))


def _check_output(spec: Spec, name: str, loop: Loop) -> None:
    output = spec.controller.outputs[loop.heater]
    if isinstance(output, DigitalOutput):
        raise Refused(
            f"{spec.file_name}: heater {loop.heater} is switched on and off only, and a PID asks "
            "for parts of its power. Make it time_proportional or pwm."
        )
    if power_of(spec.controller, name) is None:
        raise Refused(
            f"{spec.file_name}: heater {loop.heater} has no power. Give it one: power: 40 W."
        )


def _target(spec: Spec, name: str) -> float:
    """Choose where to tune: the highest temperature of the scenario, or what the loop starts with.

    A loop that starts at no more than ambient has nothing to hold there: then its highest.
    """
    loop, simulation = spec.controller.loops[name], spec.controller.simulation
    assert simulation is not None  # noqa: S101 - looked at before
    asked = max(_sent(spec.controller), default=loop.setpoint.initial_c)
    if asked > simulation.ambient_c:
        return min(asked, loop.setpoint.maximum_c)
    return loop.setpoint.maximum_c


def _sent(controller: Controller) -> Iterator[float]:
    if controller.simulation is not None:
        for event in controller.simulation.scenario:
            found = _ASKED.search(event.send) if event.send is not None else None
            if found:
                yield float(found[1])
            for write in event.write or ():
                if write.what == "setpoint":
                    yield write.value


def _within(loop: Loop, at_c: float) -> float:
    low_c, high_c = loop.setpoint.minimum_c, loop.setpoint.maximum_c
    if not low_c <= at_c <= high_c:
        raise Refused(
            f"--at {celsius(at_c)}: the loop's setpoints are {celsius(low_c)} to {celsius(high_c)}."
        )
    return at_c


def _warm_s(spec: Spec, process: Process, loop: Loop, target_c: float) -> float:
    """Return how long full power takes from cold to the target."""
    simulation = spec.controller.simulation
    assert simulation is not None  # noqa: S101 - looked at before
    algorithm = loop.algorithm
    full = algorithm.output.maximum_percent if isinstance(algorithm, Pid) else 100.0
    target_k = target_c - simulation.ambient_c
    if target_k <= 0:
        raise Refused(f"{celsius(target_c)} is no warmer than the ambient: there is nothing to do.")
    if process.gain * full <= target_k:
        ends_c = simulation.ambient_c + process.gain * full
        raise Refused(
            f"{celsius(target_c)} is beyond this machine: full power ends at {about(ends_c)} °C."
        )
    step_s = process.lags_s[0] / 100
    step, given = process.held(step_s)
    state, time_s = 0.0 * process.heat, process.late_s
    while float(process.reading @ state) < target_k and time_s < LONGEST_S:
        state = step @ state + given * full
        time_s += step_s
    return time_s


def _filter_s(process: Process, loop: Loop) -> float:
    if isinstance(loop.algorithm, Pid) and loop.algorithm.derivative_filter_s > 0:
        return loop.algorithm.derivative_filter_s
    unfiltered = model_for(process, loop.period_s, 0.0)
    return max(loop.period_s, unfiltered.second_s / FILTER_SHARE)
