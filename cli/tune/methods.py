"""The methods of tuning, each judged by its margins and tried in the closed loop."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from heatwright.cli.ends import Refused
from heatwright.cli.talk import Job, Talk
from heatwright.sim.judges.metrics import Metrics, metrics
from heatwright.sim.plots.plot_data import Tripped, faults
from heatwright.sim.trace import Trace
from heatwright.sim.tuning.disturbed import Load, load_answer, step_kick
from heatwright.sim.tuning.gains import Gains
from heatwright.sim.tuning.margins import Margins, OpenLoop, margins, open_loop
from heatwright.sim.tuning.process import Process
from heatwright.sim.tuning.reduced import Reduced
from heatwright.sim.tuning.robust import Machine, is_sound
from heatwright.sim.tuning.rules import lambda_rule, model_for, robust_simc, simc
from heatwright.sim.tuning.trial import TuningFailed, relay, try_gains
from heatwright.spec import Controller

OWN = "as it is"
"""The row of the spec's own gains."""
ROBUST = "robust"
"""The row of the gains of --robust, which suit all random machines."""

SETTLING = 5.0
"""Length of a trial after it has reached the target, in integral times."""


@dataclass(frozen=True)
class Task:
    """The loop to tune, and the options."""

    controller: Controller
    loop: str
    target_c: float
    process: Process
    warm_s: float
    """Time from cold to the target at full power, s."""
    filter_s: float
    lambda_s: float | None = None
    tauc_s: float | None = None

    @property
    def period_s(self) -> float:
        """Time between control steps, s."""
        return self.controller.loops[self.loop].period_s

    def open_loop(self, gains: Gains) -> OpenLoop:
        """Return the frequency response of the open loop of machine and gains."""
        return open_loop(self.process, gains, self.period_s)

    def margins(self, gains: Gains, process: Process) -> Margins:
        """Return the margins of gains on a process, such as a machine that is drawn."""
        return margins(process, gains, self.period_s)

    def are_sound(self, gains: Gains, machines: Iterable[Machine]) -> bool:
        """Return whether the loop with these gains is sound on every machine (margins.SOUND)."""
        return is_sound(gains, machines, self.period_s)

    @property
    def model(self) -> Reduced:
        """The reduced model of the machine, which simc and lambda use."""
        return model_for(self.process, self.period_s, self.filter_s)

    @property
    def step_k(self) -> float:
        """One step of the sensor at the target, K."""
        sensor = self.controller.thermometers[self.controller.loops[self.loop].sensor]
        return sensor.step_at_k(self.target_c, self.controller.board.mcu)


@dataclass(frozen=True)
class Judged:
    """One method's gains, and how good they are."""

    method: str
    gains: Gains
    margins: Margins
    load: Load | None
    """Effect of a load; None if the loop is not stable."""
    kick_percent: float
    """Change of the duty for one step of the sensor."""


@dataclass(frozen=True)
class Failed:
    """A method that found no gains."""

    method: str
    reason: str


@dataclass(frozen=True)
class Tried:
    """The trial of gains in the closed loop."""

    trace: Trace
    figures: Metrics
    faults: tuple[Tripped, ...]


def find(task: Task, methods: Sequence[str], shown: Talk) -> list[Judged | Failed]:
    """Run every method, and judge its gains and the spec's own."""
    spec = task.controller.loops[task.loop].algorithm.pid
    rows: list[Judged | Failed] = []
    if spec:
        own = Gains(spec.kp, spec.ki, spec.kd, spec.derivative_filter_s)
        rows.append(judged(task, OWN, own))
    for method in methods:
        job = shown.begin(f"Tuning {task.loop} by {method}")
        try:
            gains = _FINDERS[method](task, job)
        except TuningFailed as error:
            job.end(str(error))
            rows.append(Failed(method, str(error)))
            continue
        rows.append(judged(task, method, gains))
        job.end()
    return rows


def judged(task: Task, method: str, gains: Gains) -> Judged:
    """Judge a method's gains by their margins, and by their response to a load."""
    found = task.margins(gains, task.process)
    load = load_answer(task.process, gains, task.period_s) if found.stable else None
    return Judged(method, gains, found, load, step_kick(gains, task.step_k, task.period_s))


def try_all(task: Task, rows: Sequence[Judged], shown: Talk) -> dict[str, Tried]:
    """Heat with each row's gains, all for the same time."""
    slow_s = max((each.gains.kp / each.gains.ki for each in rows if each.gains.ki), default=0.0)
    length_s = task.warm_s + SETTLING * max(slow_s, task.warm_s)
    return {each.method: _tried(task, each, length_s, shown) for each in rows}


def proposed(rows: Sequence[Judged], tried: Mapping[str, Tried]) -> Judged | None:
    """Return the first row with a sound loop and a trial that trips nothing; None without rows.

    If there is none, a stable loop is preferred, then a trial that trips nothing, then a lower Ms.
    """

    def doubts(row: Judged) -> tuple[bool, bool, float]:
        found = row.margins
        return (
            not found.stable,
            bool(tried[row.method].faults),
            0.0 if found.sound else found.sensitivity,
        )

    return min(rows, key=doubts, default=None)


def _tried(task: Task, row: Judged, length_s: float, shown: Talk) -> Tried:
    job = shown.begin(f"Trying {task.loop} {row.method}")
    trace = try_gains(
        task.controller,
        task.loop,
        row.gains,
        target_c=task.target_c,
        length_s=float(round(length_s)),
        progress=job,
    )
    job.end()
    try:
        figures = metrics(trace, task.controller, task.loop)
    except ValueError as error:
        raise Refused(f"{error}.") from None
    return Tried(trace, figures, faults(trace.steps[task.loop]))


def _simc(task: Task, _: Job) -> Gains:
    if task.tauc_s is None:
        return robust_simc(task.process, task.model, task.filter_s, task.period_s)
    return simc(task.model, task.filter_s, task.tauc_s)


_FINDERS: dict[str, Callable[[Task, Job], Gains]] = {
    "relay": lambda task, job: relay(task.controller, task.loop, task.target_c, job),
    "simc": _simc,
    "lambda": lambda task, _: lambda_rule(task.model, task.filter_s, task.lambda_s),
}
