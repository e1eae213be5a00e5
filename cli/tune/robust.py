"""`tune --robust`: gains for all machines within the tolerances, beside the other methods'."""

import math
from collections.abc import Sequence
from itertools import count
from statistics import median
from typing import Any, NamedTuple

from heatwright.cli.ends import Refused
from heatwright.cli.figures import NONE, rounded
from heatwright.cli.talk import Job, Talk
from heatwright.cli.tune.methods import ROBUST, SETTLING, Failed, Judged, Task, judged
from heatwright.cli.tune.task import warm_s
from heatwright.sim.tuning.gains import Gains
from heatwright.sim.tuning.margins import SOUND
from heatwright.sim.tuning.process import process_of
from heatwright.sim.tuning.robust import (
    Course,
    Machine,
    Outcome,
    Spread,
    drawn,
    improved,
    worst_cost,
)
from heatwright.spec.quantity import about, celsius

COLUMNS = (
    "method",
    "Ms, worst",
    "overshoot [K], median",
    "worst",
    "settled after [s], median",
    "worst",
    "never settled",
    "tripped",
)


class Wish(NamedTuple):
    """The options of --robust."""

    machines: int
    spread: Spread
    seed: int


class Row(NamedTuple):
    """How good a method's gains are on all machines."""

    method: str
    sensitivity: float | None
    """Ms on the worst machine; None if the loop is unstable on one."""
    outcomes: Sequence[Outcome]


class Trade(NamedTuple):
    """All methods, tried on machines that none of them was tuned for."""

    wish: Wish
    left_out: int
    """Number of machines that cannot reach the target."""
    rows: Sequence[Row]


def robust(
    task: Task, rows: Sequence[Judged | Failed], wish: Wish, shown: Talk
) -> tuple[Judged | Failed, Trade]:
    """Improve the best gains of the other methods for random machines, and try all on others.

    Raises Refused: no machine reaches the target.
    """
    job = shown.begin(f"Tuning {task.loop} for {wish.machines} machines")
    ours, _ = _machines(task, wish, wish.seed)
    good = [row for row in rows if isinstance(row, Judged)]
    found = _improved(task, good, ours, job)
    job.end(found.reason if isinstance(found, Failed) else "")
    good += [found] if isinstance(found, Judged) else []
    job = shown.begin(f"Trying {task.loop} on {wish.machines} other machines")
    others, left_out = _machines(task, wish, wish.seed + 1)
    outcomes = _course(task, good, others).tried([row.gains for row in good], others, job)
    job.end()
    trade = [
        Row(row.method, _sensitivity(task, row.gains, others), each)
        for row, each in zip(good, outcomes, strict=True)
    ]
    return found, Trade(wish, left_out, trade)


def _machines(task: Task, wish: Wish, seed: int) -> tuple[list[Machine], int]:
    """Draw machines at random; those that cannot reach the target are only counted."""
    found: list[Machine] = []
    for controller in drawn(task.controller, wish.spread, wish.machines, seed):
        process = process_of(controller, task.loop, task.target_c)
        try:
            warm = warm_s(controller, task.loop, process, task.target_c)
        except Refused:
            continue
        found.append(Machine(controller, process, warm))
    if not found:
        raise Refused(
            f"--robust: none of {wish.machines} machines reaches {celsius(task.target_c)}. "
            "Tune at a lower temperature, --at, or give the heater more power."
        )
    return found, wish.machines - len(found)


def _course(task: Task, rows: Sequence[Judged], machines: Sequence[Machine]) -> Course:
    slow_s = max((row.gains.kp / row.gains.ki for row in rows if row.gains.ki), default=0.0)
    warm = max(each.warm_s for each in machines)
    length_s = float(round(warm + SETTLING * max(slow_s, warm)))
    return Course(task.controller, task.loop, task.target_c, length_s, task.step_k)


def _improved(
    task: Task, rows: Sequence[Judged], machines: Sequence[Machine], job: Job
) -> Judged | Failed:
    sound = [row for row in rows if task.are_sound(row.gains, machines)]
    if not sound:
        reason = f"no method has gains with an Ms of at most {SOUND:g} on all machines"
        return Failed(ROBUST, reason)
    outcomes = _course(task, sound, machines).tried([row.gains for row in sound], machines, job)
    costs = [worst_cost(each) for each in outcomes]
    best = costs.index(min(costs))
    course = _course(task, [sound[best]], machines)
    rounds = count(1)

    def costs_of(asked: Sequence[Gains]) -> list[float]:
        job.note(f"round {next(rounds)}")
        able = [each for each in asked if task.are_sound(each, machines)]
        found = dict(zip(able, course.tried(able, machines, job), strict=True)) if able else {}
        return [worst_cost(found[each]) if each in found else math.inf for each in asked]

    start = sound[best].gains._replace(integral_percent=None)
    (cost,) = costs_of([start])
    return judged(task, ROBUST, improved(start, cost, costs_of))


def _sensitivity(task: Task, gains: Gains, machines: Sequence[Machine]) -> float | None:
    found = [task.margins(gains, each.process) for each in machines]
    return max(each.sensitivity for each in found) if all(each.stable for each in found) else None


def line(row: Row) -> tuple[str, ...]:
    """Return a row of the table."""
    told = _told(row)
    return (
        row.method,
        "unstable" if row.sensitivity is None else f"{row.sensitivity:.2f}",
        f"{told['overshoot']['median']:+.2f}",
        f"{told['overshoot']['worst']:+.2f}",
        *(NONE if each is None else f"{each:.0f}" for each in told["settling_s"].values()),
        str(told["never_settled"] or NONE),
        str(told["tripped"] or NONE),
    )


def legend(task: Task, trade: Trade) -> list[str]:
    """Describe the machines, below the table."""
    wish, spread = trade.wish, trade.wish.spread
    tried = wish.machines - trade.left_out
    lines = [
        f"On {tried} random machines that no method was tuned for: capacities and resistances "
        f"± {about(100 * spread.share)} %, ambient ± {about(spread.ambient_k)} K, supply "
        f"± {about(100 * spread.supply)} %."
    ]
    if trade.left_out:
        lines.append(
            f"{trade.left_out} of {wish.machines} cannot reach {celsius(task.target_c)} at full "
            "power, and are left out."
        )
    return lines


def as_json(trade: Trade) -> dict[str, Any]:
    """Return the trade as JSON data."""
    wish = trade.wish
    return {
        "machines": wish.machines,
        "left_out": trade.left_out,
        "seed": wish.seed,
        "spread": {
            "share": wish.spread.share,
            "ambient": wish.spread.ambient_k,
            "supply": wish.spread.supply,
        },
        "methods": [
            {
                "method": row.method,
                "sensitivity": None if row.sensitivity is None else rounded(row.sensitivity),
                **_told(row),
            }
            for row in trade.rows
        ],
    }


def _told(row: Row) -> dict[str, Any]:
    overshoots = [each.overshoot_k for each in row.outcomes]
    settled = [each.settling_s for each in row.outcomes if each.settling_s is not None]
    return {
        "overshoot": {"median": rounded(median(overshoots)), "worst": rounded(max(overshoots))},
        "settling_s": {
            "median": rounded(median(settled)) if settled else None,
            "worst": rounded(max(settled)) if settled else None,
        },
        "never_settled": len(row.outcomes) - len(settled),
        "tripped": sum(each.tripped for each in row.outcomes),
    }
