"""The model on arrays is the model: each step of each lane, bit for bit, for drawn controllers."""

import ast
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from itertools import islice
from random import Random
from typing import Any, NamedTuple

import numpy as np
import pytest
from rig.controllers import drawings
from rig.firmware import example
from suite import SEED, amount

from heatwright.sim import player
from heatwright.sim.arrays import masks, steps
from heatwright.sim.arrays.masks import AllLanesError, only
from heatwright.sim.arrays.modules import on_arrays
from heatwright.sim.arrays.stack import UnlikeError, stacked
from heatwright.sim.arrays.steps import are_repeated
from heatwright.sim.arrays.translate import translated
from heatwright.sim.arrays.world import bench_lanes, step_logs
from heatwright.sim.bench import bench
from heatwright.sim.reference import Record, Reference
from heatwright.sim.reference.device import ReferenceDevice
from heatwright.sim.reference.inputs import Gains, Limits, Orders
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.programs.state import IDLE, PAUSED, RETURNING, RUNNING
from heatwright.sim.trace import StepLog, Trace
from heatwright.sim.tuning.robust import Spread, drawn
from heatwright.spec import Controller, Event, Pid, facts_of
from heatwright.spec.registry import module_of

LANES = 7
MACHINES = 3
ALGORITHMS = {"pid", "on_off", "three_position"}
SPREAD = {
    "kp": 0.9, "ki": 0.9, "kd": 0.9, "derivative_filter_s": 0.5, "feed_forward": 0.5,
    "lead_s": 0.5, "lead_filter_s": 0.5, "hysteresis_k": 0.3,
}  # fmt: skip
"""By how much a lane's number may differ; zeros stay, for what they leave out is no number."""


class Given(NamedTuple):
    """What one lane is given in a step."""

    status: int
    raw: int
    setpoint_c: Single
    acknowledge: bool
    orders: Orders


class Case(NamedTuple):
    """A loop of a drawn controller in variants, one a lane."""

    loop: str
    lanes: tuple[Controller, ...]
    course: tuple[tuple[Given, ...], ...]
    tunes_at: int


def varied(controller: Controller, loop: str, random: Random) -> Controller:
    """Change numbers of algorithm and protections, as no checks would have to allow it."""
    spec = controller.loops[loop]
    changes = {
        name: getattr(spec.algorithm, name) * (1 + random.uniform(-width, width))
        for name, width in SPREAD.items()
        if hasattr(spec.algorithm, name)
    }
    algorithm = spec.algorithm.model_copy(update=changes)
    protection = spec.protection.model_copy(
        update={
            "maximum_c": spec.protection.maximum_c + random.uniform(-5, 5),
            "rise_rate_k_per_s": spec.protection.rise_rate_k_per_s * random.uniform(1, 9),
        }
    )
    changed = spec.model_copy(update={"algorithm": algorithm, "protection": protection})
    return controller.with_loop(loop, changed)


def course_of(controller: Controller, loop: str, steps: int, random: Random) -> list[Given]:
    """Readings that wander about the setpoint, and fail; and all orders that a step takes."""
    spec = controller.loops[loop]
    sensor = controller.thermometers[spec.sensor]
    module = import_module(module_of("sensor", "reference", sensor.kind))
    ideal = module.IdealSensor(sensor, controller.board)
    ends = spec.setpoint
    setpoint_c = ends.initial_c or ends.maximum_c
    felt_c, orders = setpoint_c - random.choice([0, 5, 60]), Orders(enabled=1)
    names = facts_of(controller, loop).monitored
    pid = spec.algorithm if isinstance(spec.algorithm, Pid) else None
    found = []
    for _ in range(steps):
        felt_c += random.gauss(0, 0.3) + (setpoint_c - felt_c) * random.choice([0.0, 0.02])
        if random.random() < 0.01:
            felt_c = random.uniform(0, spec.protection.maximum_c + 5)
        status, raw = ideal.read(felt_c)
        if random.random() < 0.05:
            status = random.choice([1, 2, 17, 18])
        if random.random() < 0.03:
            own_c = [ends.minimum_c, ends.maximum_c]
            setpoint_c = random.choice([0.0, *own_c, felt_c, felt_c + 1])
        if random.random() < 0.05:
            orders = orders._replace(
                mode=random.choice([0, 0, 0, 1, 2]) if facts_of(controller, loop).tunable else 0,
                manual_percent=Single(random.uniform(0, 100)),
                enabled=int(random.random() < 0.8),
            )
        jitter = 1 + 0.1 * (random.random() < 0.1)
        orders = orders._replace(
            gains=pid and Gains(*(Single(g * jitter) for g in (pid.kp, pid.ki, pid.kd))),
            limits=pid and Limits(
                Single(pid.integral.minimum_percent),
                Single(pid.integral.maximum_percent),
                Single(pid.output.maximum_percent * random.choice([1, 1, 1, 0.7, 0])),
            ),
            maximum_c=Single(spec.protection.maximum_c),
            master_lost=random.random() < 0.01,
            current_raw=random.randrange(400),
            watch_fault=25 * (random.random() < 0.002),
            numbers={
                each.kind.field: Single(each.value * random.choice([1, 1, 1.1, 0, -1]))
                for each in facts_of(controller, loop).keyed_numbers
            },
            monitors={name: (17 * (random.random() < 0.1), random.randrange(900))
                      for name in names},
        )  # fmt: skip
        found.append(Given(status, raw, Single(setpoint_c), random.random() < 0.2, orders))
    return found


@cache
def cases() -> tuple[Case, ...]:
    """Loops without a program, of drawn controllers."""
    random = Random(f"lanes {SEED}")  # noqa: S311 - no secret
    drawn, found, steps = drawings(random), [], amount("lane_steps")
    while len(found) < amount("lane_loops"):
        controller = next(drawn).spec.controller
        for loop in controller.loops:
            if facts_of(controller, loop).programmed:
                continue
            lanes = tuple(varied(controller, loop, random) for _ in range(LANES))
            course = zip(*(course_of(each, loop, steps, random) for each in lanes), strict=True)
            found.append(Case(loop, lanes, tuple(course), random.randrange(steps)))
    return tuple(found)


def on_its_own(case: Case, lane: int) -> list[Record]:
    reference, found = Reference(case.lanes[lane], case.loop), []
    for number, row in enumerate(case.course):
        if reference.steering.tuner and number == case.tunes_at and lane % 2:
            reference.steering.tuner.start()
        status, raw, setpoint, acknowledge, orders = row[lane]
        found.append(reference.step(status, raw, setpoint, acknowledge=acknowledge, orders=orders))
    return found


def as_lanes(case: Case) -> list[Record]:
    module = on_arrays("heatwright.sim.reference.loop")
    reference = stacked([module.Reference(each, case.loop) for each in case.lanes])
    found = []
    for number, row in enumerate(case.course):
        if reference.steering.tuner and number == case.tunes_at:
            with only(np.arange(LANES) % 2 == 1):
                reference.steering.tuner.start()
        status, raw, setpoint, acknowledge, orders = stacked(list(row))
        found.append(reference.step(status, raw, setpoint, acknowledge=acknowledge, orders=orders))
    return found


def test_each_lane_is_the_model() -> None:
    kinds, parted = set(), 0
    for case in cases():
        members = Reference(case.lanes[0], case.loop).members
        together, alone = as_lanes(case), [on_its_own(case, lane) for lane in range(LANES)]
        for name, width in members:
            expected = np.array([[record[name] for record in each] for each in alone], width)
            found = np.array([np.broadcast_to(each[name], LANES) for each in together], width).T
            assert expected.tobytes() == found.tobytes(), (case.loop, name)
            parted += name == "fault.code" and len(set(map(bytes, expected))) > 1
        kinds.add(case.lanes[0].loops[case.loop].algorithm.kind)
    assert kinds == ALGORITHMS
    assert parted > len(cases()) / 4, "lanes hardly ever part"


def log_of(case: Case) -> StepLog:
    records = on_its_own(case, 0)
    members = Reference(case.lanes[0], case.loop).members
    rows = [(float(number), *record.values()) for number, record in enumerate(records)]
    return np.array(rows, [("time_s", "f8"), *members])


WITHIN_A_STEP = ("top_percent", "_lost")
"""What one part of a step leaves to a later one, if there is a later one."""


def state_in(part: Any, path: str = "") -> dict[str, str]:
    """Return every number in a model that lasts from step to step, by its path."""
    if isinstance(part, int | float | np.generic):
        return {path: float(part).hex()}
    parts: Any = part if isinstance(part, dict) else {}
    if isinstance(part, list | tuple):
        parts = dict(enumerate(part))
    elif type(part).__module__.startswith("heatwright.sim.reference"):
        parts = {name: each for name, each in vars(part).items() if name not in WITHIN_A_STEP}
    inner = [state_in(each, f"{path}.{name}") for name, each in parts.items()]
    return {name: value for each in inner for name, value in each.items()}


def played(
    controller: Controller, loop: str, log: StepLog, *, at_once: bool
) -> tuple[bytes, dict[str, str], int]:
    """Return what the replay expects, the model's state a step later, and the rows at once.

    at_once -- whether rows may be repeated at once; the last number is 0 if any series was not.
    """
    done, series = 0, []

    def are_done(controller: Controller, loop: str, log: StepLog, since: Reference) -> bool:
        nonlocal done
        series.append(at_once and are_repeated(controller, loop, log, since))
        done += len(log) - 1
        return series[-1]

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(player, "FEWEST_AT_ONCE", 2)
        patched.setattr(player, "are_repeated", are_done)
        model = player.Player(controller, loop)
        states = model.play(log)
    last = len(log) - 1
    model._play_singly(states.copy(), last, last + 1)
    return states.tobytes(), state_in(model._reference), done * all(series)


def logs_at_once(random: Random) -> Iterator[tuple[Controller, str, StepLog]]:
    """Yield logs of drawn loops, and of examples: a program, and several loops under a master."""
    for case in cases():
        yield case.lanes[0], case.loop, log_of(case)
    for name, minutes in (("kiln", 5), ("kiln_uno", 55), ("barrel", 15), ("fabricator", 5)):
        controller = example(name).controller
        scenario = controller.simulated.scenario
        begun = [
            each for each in scenario if each.for_s is None and (each.at_s or 0) < 60 * minutes
        ]
        end = Event.model_validate({"for": f"{minutes} min"})
        found = bench(controller, ReferenceDevice(controller), (*begun, end)).steps
        loop = random.choice(list(found))
        yield controller, loop, found[loop]


@pytest.mark.parametrize("damaged", [False, True])
def test_all_steps_at_once_are_the_model(damaged: bool) -> None:
    """Also of a log in which one bit is wrong, about which the model knows nothing."""
    random = Random(f"bits {SEED}")  # noqa: S311 - no secret
    rows = at_once = 0
    states: set[int] = set()
    for controller, loop, log in logs_at_once(random):
        member = random.choice(log.dtype.names[1:])
        if damaged and log.dtype[member].names is None:
            log[member].view(f"u{log.dtype[member].itemsize}")[random.randrange(len(log))] ^= 1
        singly, state, _ = played(controller, loop, log, at_once=False)
        found, found_state, done = played(controller, loop, log, at_once=True)
        assert (found, found_state) == (singly, state), (loop, member)
        assert damaged or done
        rows, at_once = rows + len(log), at_once + done
        if "program.state" in (log.dtype.names or ()):
            states |= set(log["program.state"].tolist())
    assert damaged or at_once > rows / 2, "hardly any step is done at once"
    assert states >= {IDLE, RUNNING, PAUSED, RETURNING}


@pytest.mark.parametrize("role", ["algorithm", "sensor"])
def test_a_model_from_outside_is_repeated_row_by_row(
    role: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It may remember what is no member of the log: side by side that would begin anew."""
    case = cases()[0]
    controller, log = case.lanes[0], log_of(case)
    kinds = {
        "algorithm": controller.loops[case.loop].algorithm.kind,
        "sensor": controller.thermometers[controller.loops[case.loop].sensor].kind,
    }
    assert played(controller, case.loop, log, at_once=True)[2]
    monkeypatch.setattr(steps, "brought", lambda of: {kinds[role]} if of == role else set())
    assert not played(controller, case.loop, log, at_once=True)[2]


def assert_same(alone: Trace, lane: Trace) -> None:
    for name, log in alone.steps.items():
        for member in log.dtype.names or ():
            assert log[member].tobytes() == lane.steps[name][member].tobytes(), (name, member)
    for part in ("temperatures_c", "sensed_c", "on_fraction", "currents_a"):
        for name, series in getattr(alone, part).items():
            assert series.tobytes() == getattr(lane, part)[name].tobytes(), (part, name)
    assert alone.fed_mm_per_s.tobytes() == lane.fed_mm_per_s.tobytes()


def assert_lanes(controller: Controller, scenario: tuple[Event, ...]) -> None:
    machines = list(drawn(controller, Spread(0.5, 10.0, 0.1), MACHINES, 0))
    lanes = bench_lanes([controller] * MACHINES, scenario, machines=machines, seed=5)
    for machine, lane in zip(machines, lanes, strict=True):
        assert_same(bench(machine, ReferenceDevice(controller), scenario, seed=5), lane)


def test_devices_on_drawn_machines() -> None:
    """Few drawn controllers with a machine do what lanes cannot."""
    random = Random(f"machines {SEED}")  # noqa: S311 - no secret
    controllers = (each.spec.controller for each in drawings(random))
    simulated = (each for each in controllers if each.simulation)
    refused = 0
    for controller in islice(simulated, amount("lane_machines")):
        try:
            assert_lanes(controller, controller.simulated.scenario)
        except (AllLanesError, UnlikeError):
            refused += 1
    assert refused <= amount("lane_machines") / 5


@pytest.mark.parametrize("name", ["chamber", "kiln", "fabricator"])
def test_examples_on_drawn_machines(name: str) -> None:
    """Three-position, programs and radiation, noisy sums and a measured current."""
    controller = example(name).controller
    scenario = controller.simulated.scenario
    begun = (each for each in scenario if each.for_s is None and (each.at_s or 0) < 15)
    assert_lanes(controller, (*begun, Event.model_validate({"for": "20 s"})))


def test_who_differs_by_more_than_numbers_is_done_alone() -> None:
    """`step_logs` has the same to tell of lanes that are no lanes."""
    controller = example("oven").controller
    loop = next(iter(controller.loops))
    spec = controller.loops[loop]
    assert isinstance(spec.algorithm, Pid)
    algorithm = spec.algorithm.model_copy(update={"kd": 0.0 if spec.algorithm.kd else 1.0})
    other = spec.model_copy(update={"algorithm": algorithm})
    both = [controller, controller.with_loop(loop, other)]
    scenario = (Event.model_validate({"for": "20 s"}),)
    found = step_logs(both, scenario, ["duty_percent"])
    for own, lane in zip(both, found, strict=True):
        alone = bench(own, ReferenceDevice(own), scenario).steps[loop]
        assert alone["duty_percent"].tobytes() == lane[loop]["duty_percent"].tobytes()


def translated_call(source: str, *arguments: Any) -> Any:
    code = compile(translated(ast.parse(source)), "source", "exec")
    known: dict[str, Any] = {"_lanes": masks}
    exec(code, known)  # noqa: S102 - our own
    return known["f"](*arguments)


SOME = np.array([True, False])


@pytest.mark.parametrize(
    "body",
    [
        "if x:\n  raise ValueError", "if x:\n  y.append(1)", "if x:\n  del y[0]",
        "for z in y:\n  if x:\n   break", "if x:\n  y = None\n else:\n  y = 'text'",
    ],
)  # fmt: skip
def test_what_would_happen_to_all_is_refused_for_some(body: str) -> None:
    with pytest.raises(AllLanesError), only(None):
        translated_call(f"def f(x, y):\n {body}\n return y", SOME, [1, 2])
    with only(None):
        translated_call(f"def f(x, y):\n {body}\n return y", False, [1, 2])


def test_a_statement_that_no_rule_is_for_is_not_translated() -> None:
    with pytest.raises(NotImplementedError, match="Try in line 2"):
        translated_call("def f(x):\n try:\n  return x\n finally:\n  pass", SOME)
