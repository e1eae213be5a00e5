"""The rows of a comparison as a table: our figures, with the published ones below."""

from collections.abc import Iterator, Sequence
from typing import Any

from heatwright.cli.compare.rows import Outcome
from heatwright.cli.figures import as_json, build_json, replay_json, rounded
from heatwright.sim.judges.metrics import Metrics
from heatwright.sim.plots.plot_data import closer
from heatwright.sim.replay import ReplayResult
from heatwright.spec import Published

COLUMNS = (
    "algorithm, setpoint",
    "max [°C]",
    "over [K]",
    "steady [°C]",
    "steady error [K]",
    "switched on",
)

ROOM = 1.15
"""Height of a row's picture, divided by that of the curves in it."""


def lines(outcome: Outcome) -> list[tuple[str, ...]]:
    """Return a row's figures in the order of COLUMNS; below them published ones and residuals."""
    row, figures = outcome.row, outcome.figures
    ours = _figures(
        row.setpoint_c, figures.maximum_c, figures.steady_minimum_c, figures.steady_maximum_c
    )
    switched = "audible" if figures.audible else f"{figures.switchings:.0f} times"
    found = [(outcome.title, *ours, switched)]
    if row.published is not None:
        given = _figures(row.setpoint_c, row.published.maximum_c, *row.published.steady_c)
        found.append(("  published", *given, ""))
        maximum_k, low_k, high_k = _residuals(figures, row.published)
        steady = f"{low_k:+.2f} … {high_k:+.2f}"
        found.append(("  residual", f"{maximum_k:+.2f}", "", steady, "", ""))
    return found


def _residuals(figures: Metrics, published: Published) -> tuple[float, float, float]:
    """Return our maximum, lowest and highest temperature, minus the published ones, in K."""
    return (
        figures.maximum_c - published.maximum_c,
        figures.steady_minimum_c - published.steady_minimum_c,
        figures.steady_maximum_c - published.steady_maximum_c,
    )


def _figures(setpoint_c: float, maximum_c: float, low_c: float, high_c: float) -> tuple[str, ...]:
    return (
        f"{maximum_c:.2f}",
        f"{max(0.0, maximum_c - setpoint_c):+.2f}",
        f"{low_c:.2f} … {high_c:.2f}",
        f"{low_c - setpoint_c:+.2f} … {high_c - setpoint_c:+.2f}",
    )


def half_heights(outcomes: Sequence[Outcome]) -> dict[str, float]:
    """Return for each loop half of the height, in K, that its rows' pictures need."""
    halves: dict[str, float] = {}
    for outcome in outcomes:
        halves[outcome.loop] = max(halves.get(outcome.loop, 0.0), _half(outcome))
    return halves


def _half(outcome: Outcome) -> float:
    low_c, high_c = closer(outcome.log)
    half_k = (high_c - low_c) / 2
    published = outcome.row.published
    if published is None:
        return half_k
    ends = (published.maximum_c, *published.steady_c)
    return max(half_k, *(ROOM * abs(end - outcome.row.setpoint_c) for end in ends))


def rows_json(outcomes: Sequence[Outcome]) -> list[dict[str, Any]]:
    """Return the rows as JSON data."""
    return [
        {
            "name": outcome.row.name,
            "loop": outcome.loop,
            "algorithm": outcome.row.algorithm.kind,
            "setpoint": outcome.row.setpoint_c,
            "closed_loop": as_json(outcome.figures),
            "steady_error": rounded(outcome.figures.steady_error_k),
            "audible": outcome.figures.audible,
            "published": _published_json(outcome.row.published),
            "residual": _residual_json(outcome.figures, outcome.row.published),
            "build": None if outcome.built is None else build_json(outcome.built),
            "replay": replay_json(outcome.replays.values()) if outcome.replays else None,
        }
        for outcome in outcomes
    ]


def _published_json(published: Published | None) -> dict[str, float] | None:
    if published is None:
        return None
    return {
        "maximum": published.maximum_c,
        "steady_min": published.steady_minimum_c,
        "steady_max": published.steady_maximum_c,
    }


def _residual_json(figures: Metrics, published: Published | None) -> dict[str, Any] | None:
    if published is None:
        return None
    found = map(rounded, _residuals(figures, published))
    return dict(zip(("maximum", "steady_min", "steady_max"), found, strict=True))


def replays(outcomes: Sequence[Outcome]) -> Iterator[ReplayResult]:
    """Yield the results of the replays of all rows and loops."""
    return (each for outcome in outcomes for each in outcome.replays.values())


def mismatches(outcomes: Sequence[Outcome]) -> int:
    """Count the variables that differ from the model's, over all rows."""
    return replay_json(replays(outcomes))["mismatches"]


def ticks(outcomes: Sequence[Outcome]) -> int:
    """Count the control steps compared with the model, over all rows."""
    return replay_json(replays(outcomes))["ticks"]
