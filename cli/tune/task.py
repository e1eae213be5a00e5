"""The loops to tune and the methods, from the spec and the options."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from heatwright.cli.ends import Refused
from heatwright.cli.tune.methods import Task
from heatwright.sim.tuning.process import Process, at_full_power, power_of, process_of
from heatwright.sim.tuning.rules import model_for
from heatwright.spec import Controller, Loop, Spec, facts_of
from heatwright.spec.quantity import about, celsius

LONGEST_S = 48 * 3600.0
"""Longest time to heat up; a plant that needs longer has a typing error."""

STEPS_PER_LAG = 100
ENDS_LAGS = 15
"""Time after which a rise is over, divided by the slowest lag: e^−15 is 3 · 10⁻⁷."""

FILTER_SHARE = 10.0
"""Derivative time divided by its filter time, if the spec has no filter (Åström & Hägglund,
Advanced PID Control, 2006, section 3.3: two to twenty)."""

_ASKED = re.compile(r"M(104|109|140|190|141|191)\b.*?\b[RS](\d+(?:\.\d+)?)")
_CALLED = {"140": "B", "190": "B", "141": "C", "191": "C"}
_TOOL = re.compile(r"\b[TE](\d)\b")


@dataclass(frozen=True)
class Job:
    """The methods to run for one loop."""

    task: Task
    methods: tuple[str, ...]


@dataclass(frozen=True)
class Plan:
    """The loops to tune, and those to skip."""

    jobs: tuple[Job, ...]
    skipped: dict[str, str]
    """Loops that cannot be tuned, and why."""


def plan_of(  # noqa: PLR0913 - one for each option
    spec: Spec,
    loops: Sequence[str],
    asked: Sequence[str],
    every: Sequence[str],
    *,
    at_c: float | None,
    lambda_s: float | None,
    tauc_s: float | None,
) -> Plan:
    """Plan the tuning of the named loops, or of all if none is named.

    If none is named, loops that cannot be tuned with these options are skipped. Raises Refused: a
    named loop cannot be tuned, or no loop can.
    """
    jobs: list[Job] = []
    refused: dict[str, Refused] = {}
    for loop in dict.fromkeys(loops or spec.controller.loops):
        try:
            task = task_of(spec, loop, at_c=at_c, lambda_s=lambda_s, tauc_s=tauc_s)
            jobs.append(Job(task, methods_of(task, asked, every)))
        except Refused as error:
            if loops:
                raise
            refused[loop] = error
    if not jobs:
        raise next(iter(refused.values()))
    return Plan(tuple(jobs), {loop: str(error) for loop, error in refused.items()})


def task_of(
    spec: Spec, name: str, *, at_c: float | None, lambda_s: float | None, tauc_s: float | None
) -> Task:
    """Combine spec and options for one loop. Raises Refused: there is nothing to tune."""
    controller = spec.controller
    if name not in controller.loops:
        able = ", ".join(controller.loops)
        raise Refused(f"{spec.file_name}: has no loop {name}; there are {able}.")
    chosen = controller.loops[name]
    _check_output(spec, name, chosen)
    if controller.simulation is None:
        raise Refused(
            f"{spec.file_name}: has no `simulation`, so there is no machine to tune for. Describe "
            "one, or let `heatwright identify` compute it from a record of the real machine."
        )
    target_c = _target(spec, name) if at_c is None else _within(chosen, at_c)
    process = process_of(controller, name, target_c)
    warm = warm_s(controller, name, process, target_c)
    return Task(
        controller, name, target_c, process, warm, _filter_s(process, chosen), lambda_s, tauc_s
    )


def methods_of(task: Task, asked: Sequence[str], every: Sequence[str]) -> tuple[str, ...]:
    """Return the methods to run: those of --method, or all that the spec allows."""
    possible = facts_of(task.controller, task.loop).autotune
    if "relay" in asked and not possible:
        raise Refused(
            f"Loop {task.loop} cannot tune itself: relay needs `autotune: {{}}` in the loop, "
            "the algorithm pid, and an interface gcode or modbus_rtu that serves it."
        )
    return tuple(each for each in dict.fromkeys(asked or every) if possible or each != "relay")


def _check_output(spec: Spec, name: str, loop: Loop) -> None:
    if spec.controller.outputs[loop.heater].is_on_off:
        raise Refused(
            f"{spec.file_name}: heater {loop.heater} is only switched on and off, and a PID needs "
            "partial power. Make it time_proportional or pwm."
        )
    if power_of(spec.controller, name) is None:
        raise Refused(
            f"{spec.file_name}: heater {loop.heater} has no power. Give it one: power: 40 W."
        )


def _target(spec: Spec, name: str) -> float:
    """Choose where to tune: the highest temperature of scenario and programs, or the initial one.

    If it is not above ambient, the loop would not heat: the highest setpoint is chosen then.
    """
    loop, simulation = spec.controller.loops[name], spec.controller.simulated
    wanted = (*_commanded(spec.controller, name), *_program_targets(spec.controller, name))
    asked = max(wanted, default=loop.setpoint.initial_c)
    if asked > simulation.ambient_c:
        return min(asked, loop.setpoint.maximum_c)
    return loop.setpoint.maximum_c


def _commanded(controller: Controller, name: str) -> Iterator[float]:
    """Yield the setpoints that host and master send to a loop in the scenario, °C.

    A line without a tool number is for the tool chosen last; at the beginning for the first.
    """
    gcode, simulation = facts_of(controller).gcode, controller.simulation
    served = gcode.loops if gcode else {}
    active = min((each for each in served if each.startswith("T")), default="")
    for event in simulation.scenario if simulation is not None else ():
        line = (event.send or "").strip().upper()
        active = line if line in served else active
        if found := _ASKED.search(line):
            tool = _TOOL.search(line)
            called = _CALLED.get(found[1]) or (f"T{tool[1]}" if tool else active)
            if served.get(called) == name:
                yield float(found[2])
        for write in event.write or ():
            if write.what == "setpoint" and write.loop == name:
                yield write.value


def _program_targets(controller: Controller, name: str) -> Iterator[float]:
    """Yield the targets of a loop's programs, °C."""
    if controller.programs is not None and controller.programs.loop == name:
        for program in controller.programs.stored:
            yield from (each.to_c for each in program.segments if each.to_c is not None)


def _within(loop: Loop, at_c: float) -> float:
    low_c, high_c = loop.setpoint.minimum_c, loop.setpoint.maximum_c
    if not low_c <= at_c <= high_c:
        raise Refused(
            f"--at {celsius(at_c)}: the loop's setpoints are {celsius(low_c)} to {celsius(high_c)}."
        )
    return at_c


def warm_s(controller: Controller, name: str, process: Process, target_c: float) -> float:
    """Return the time from cold to the target at full power, s.

    Raises Refused: the target is out of reach.
    """
    simulation = controller.simulated
    if target_c <= simulation.ambient_c:
        raise Refused(
            f"{celsius(target_c)} is not above the ambient temperature: name a higher --at."
        )
    course = at_full_power(controller, name, process.lags_s[0] / STEPS_PER_LAG)
    felt_c = simulation.ambient_c
    for time_s, felt_c in course:
        if felt_c >= target_c:
            return time_s + process.late_s
        if time_s > ENDS_LAGS * process.lags_s[0] or time_s > LONGEST_S:
            break
    raise Refused(f"{celsius(target_c)} is out of reach: full power ends at {about(felt_c)} °C.")


def _filter_s(process: Process, loop: Loop) -> float:
    pid = loop.algorithm.pid
    if pid and pid.derivative_filter_s > 0:
        return pid.derivative_filter_s
    unfiltered = model_for(process, loop.period_s, 0.0)
    return max(loop.period_s, unfiltered.second_s / FILTER_SHARE)
