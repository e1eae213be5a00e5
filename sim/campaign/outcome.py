"""The outcome of one run of a campaign, as a row of its table."""

from collections.abc import Mapping
from typing import NamedTuple

from heatwright.sim.campaign.drawn import Drawn
from heatwright.sim.campaign.world import DrawnWorld
from heatwright.sim.faults.bears import bears_c
from heatwright.sim.judges.metrics import Metrics, metrics
from heatwright.sim.trace import Trace
from heatwright.spec import RULES, Controller

Value = float | int | str | None
Row = dict[str, Value]

WELL, TRIPPED, CAUGHT, UNNOTICED = "well", "tripped", "caught", "unnoticed"
"""Outcomes in this order: no fault and no trip; no fault, but a trip; a fault and a trip; a fault
without a trip to the end."""

FIGURES = (
    "setpoint_c", "maximum_c", "overshoot_k", "rise_time_s", "settling_s", "steady_error_k",
    "iae_ks", "switchings", "energy_j",
)  # fmt: skip
"""Figures of each loop; see heatwright.sim.judges.metrics."""


class Outcome(NamedTuple):
    """A finished run: its row in the table, and the data for its plot."""

    row: Row
    trace: Trace
    figures: Mapping[str, Metrics]


def outcome(world: DrawnWorld, drawn: Drawn, spec: Controller) -> Outcome:
    """Judge a finished run; spec -- the controller whose machine was varied."""
    trace = world.trace()
    first, broke_s = next(iter(world.trips.since(0.0)), None), world.broke_s
    after_s = first.time_s - broke_s if first and broke_s is not None else None
    figures = _figures(trace, drawn.powered)
    row: Row = {"run": drawn.run, "outcome": _word(first is not None, after_s, broke_s)}
    row["rule"] = RULES[first.code].id if first else None
    row["tripped_s"] = first.time_s if first else None
    row["tripped_after_s"] = after_s if after_s is not None and after_s >= 0 else None
    row["too_hot"] = _too_hot(world, spec)
    row |= {f"peak.{node}_c": peak_c for node, peak_c in world.peaks.highest_c.items()}
    for loop in spec.loops:
        found = figures.get(loop) if broke_s is None else None
        row |= {f"loop.{loop}.{name}": None if found is None else getattr(found, name)
                for name in FIGURES}  # fmt: skip
    row |= {f"drawn.{name}": value for name, value in drawn.values.items()}
    return Outcome(row, trace, figures)


def _word(tripped: bool, after_s: float | None, broke_s: float | None) -> str:
    if broke_s is None or (after_s is not None and after_s < 0):
        return TRIPPED if tripped else WELL
    return CAUGHT if tripped else UNNOTICED


def _figures(trace: Trace, controller: Controller) -> dict[str, Metrics]:
    found = {}
    for loop in controller.loops:
        try:
            found[loop] = metrics(trace, controller, loop)
        except ValueError:  # no reading at all
            continue
    return found


def _too_hot(world: DrawnWorld, spec: Controller) -> str | None:
    """Return the first node that became hotter than its limit (`bears`), or None."""
    borne_c = bears_c(spec, spec.simulated.plant)
    hot = (node for node, peak_c in world.peaks.highest_c.items() if peak_c > borne_c[node])
    return next(hot, None)
