"""The methods of tuning as a table, as JSON data, and the chosen one as YAML."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from heatwright.cli.figures import NONE, finite, rounded
from heatwright.cli.figures import as_json as figures_json
from heatwright.cli.tune.methods import Failed, Judged, Task, Tried
from heatwright.sim.tuning.disturbed import LOAD_PERCENT, Load
from heatwright.sim.tuning.margins import SOUND, Margins
from heatwright.spec.quantity import about, celsius, duration

COLUMNS = (
    "method",
    "kp",
    "ki",
    "kd",
    "gain margin",
    "phase margin [°]",
    "delay margin [s]",
    "Ms",
    "overshoot [K]",
    "settled after [s]",
    "error [K]",
    "dip [K]",
    "half of it after [s]",
    "step [%]",
)

GIVEN = "kp in %/K, ki in %/(K·s), kd in %·s/K"


def line(row: Judged | Failed, tried: Tried | None) -> tuple[str, ...]:
    """Return a row of the table."""
    if isinstance(row, Failed):
        return (row.method, *[NONE] * (len(COLUMNS) - 1))
    gains, found = row.gains, row.margins
    return (
        row.method,
        *(_gain(value) for value in gains[:3]),
        *_margins(found),
        *_figures(tried),
        NONE if row.load is None else f"{row.load.dip_k:.2f}",
        NONE if row.load is None or row.load.half_s is None else f"{row.load.half_s:.0f}",
        f"{row.kick_percent:.1f}",
    )


def _gain(value: float) -> str:
    return f"{value:.4g}"


def _margins(found: Margins) -> tuple[str, ...]:
    if not found.stable:
        return ("unstable", NONE, NONE, NONE)
    return (
        _finite(found.gain, ".1f"),
        _finite(found.phase_deg, ".0f"),
        _finite(found.delay_s, ".2f"),
        f"{found.sensitivity:.2f}",
    )


def _finite(value: float, form: str) -> str:
    return format(value, form) if math.isfinite(value) else "∞"


def _figures(tried: Tried | None) -> tuple[str, ...]:
    if tried is None:
        return (NONE, NONE, NONE)
    found = tried.figures
    return (
        f"{found.overshoot_k:+.2f}",
        NONE if found.settling_s is None else f"{found.settling_s:.0f}",
        f"{found.steady_error_k:.2f}",
    )


def legend(task: Task) -> list[str]:
    """Explain the columns, and describe the machine's model that simc and lambda use."""
    model, target = task.model, celsius(task.target_c)
    second = f" and {about(model.second_s)} s" if model.second_s else ""
    return [
        f"{GIVEN}. From cold to {target}; error: the largest in the last third.",
        f"dip: effect of a load of {LOAD_PERCENT:g} % of the power; step: effect of one step of "
        "the sensor on the duty.",
        f"Model for simc, lambda: {about(model.gain)} K/%, lags {about(model.lag_s)} s{second}, "
        f"dead time {about(model.dead_s)} s; sampled every {duration(task.period_s)}.",
    ]


def doubt(row: Judged, tried: Tried) -> str | None:
    """Return a warning why gains should not be used as they are; None: they can be used."""
    found = row.margins
    if not found.stable:
        reason = "its loop is unstable"
    elif not found.sound:
        reason = f"its Ms of {found.sensitivity:.2f} is above {SOUND:g}, near to instability"
    elif tried.faults:
        reason = "a protection trips in its trial"
    else:
        return None
    return f"{row.method}: {reason}. Try a longer --tauc or --lambda, or other protections."


def block(row: Judged, loop: str = "") -> str:
    """Write gains as YAML, to replace those of a loop; `loop` names it, if there are several."""
    gains = row.gains
    lines = [
        *([f"# loops.{loop}"] if loop else []),
        "algorithm:",
        "  kind: pid",
        f"  kp: {_gain(gains.kp):<12} # %/K, by {row.method}",
        f"  ki: {_gain(gains.ki):<12} # %/(K·s)",
        f"  kd: {_gain(gains.kd):<12} # %·s/K",
    ]
    if gains.kd:
        lines.append(f"  derivative_filter: {about(gains.filter_s)} s")
    if gains.integral_percent is not None:
        least, most = (about(end) for end in gains.integral_percent)
        lines.append(f"  integral: {{minimum: {least} %, maximum: {most} %}}")
    return "\n".join(lines) + "\n"


def rows_json(rows: Sequence[Judged | Failed], tried: Mapping[str, Tried]) -> list[dict[str, Any]]:
    """Return the rows as JSON data."""
    return [_row_json(row, tried.get(row.method)) for row in rows]


def _row_json(row: Judged | Failed, tried: Tried | None) -> dict[str, Any]:
    if isinstance(row, Failed):
        return {"method": row.method, "failed": row.reason}
    gains, found = row.gains, row.margins
    return {
        "method": row.method,
        "failed": None,
        "gains": {
            "kp": rounded(gains.kp),
            "ki": rounded(gains.ki),
            "kd": rounded(gains.kd),
            "derivative_filter_s": rounded(gains.filter_s),
            "integral_percent": gains.integral_percent
            and [rounded(end) for end in gains.integral_percent],
        },
        "margins": {
            "stable": found.stable,
            "gain": finite(found.gain),
            "phase_deg": finite(found.phase_deg),
            "delay_s": finite(found.delay_s),
            "sensitivity": finite(found.sensitivity),
            "crossover_rad_per_s": finite(found.crossover),
        },
        "load": _load_json(row.load),
        "step_percent": rounded(row.kick_percent),
        "closed_loop": None if tried is None else figures_json(tried.figures),
        "faults": [] if tried is None else [code for _, code in tried.faults],
    }


def _load_json(load: Load | None) -> dict[str, float | None] | None:
    if load is None:
        return None
    return {
        "percent": LOAD_PERCENT,
        "dip": rounded(load.dip_k),
        "after_s": rounded(load.after_s),
        "half_s": rounded(load.half_s),
    }


def model_json(task: Task) -> dict[str, float | None]:
    """Return the machine's model that simc and lambda use, as JSON data."""
    model = task.model
    return {
        "gain_K_per_percent": rounded(model.gain),
        "lag_s": rounded(model.lag_s),
        "second_lag_s": rounded(model.second_s),
        "dead_time_s": rounded(model.dead_s),
        "period_s": rounded(task.period_s),
    }
