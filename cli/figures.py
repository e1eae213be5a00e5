"""Figures of merit, as JSON data and as rows of tables."""

import math
from collections.abc import Iterable, Mapping
from typing import Any

from heatwright.generator.toolchain import BuildResult
from heatwright.sim.judges.disturbances import RECOVERED_K
from heatwright.sim.judges.metrics import Metrics
from heatwright.sim.replay import ReplayResult
from heatwright.spec.quantity import number

NONE = "–"
"""Written in place of a missing figure."""

COLUMNS = (
    "setpoint [°C]",
    "maximum [°C]",
    "overshoot [K]",
    "settled after [s]",
    "steady [°C]",
    "error [K]",
    "switchings",
    "energy [kJ]",
)

LOAD_COLUMNS = (
    "loop",
    "what happens",
    "at [s]",
    "lowest [K]",
    "highest [K]",
    f"stays within ±{RECOVERED_K:g} K after [s]",
)
LOAD_TEXTS = 2


def as_json(figures: Metrics) -> dict[str, Any]:
    """Return the object `closed_loop` of the JSON; units are °C, K, s and J."""
    return {
        "maximum": rounded(figures.maximum_c),
        "overshoot": rounded(figures.overshoot_k),
        "tracking": rounded(figures.tracking_k),
        "settling_s": rounded(figures.settling_s),
        "steady_min": rounded(figures.steady_minimum_c),
        "steady_max": rounded(figures.steady_maximum_c),
        "switchings": round(figures.switchings),
        "energy_J": rounded(figures.energy_j, 1),
        "loads": [
            {
                "at_s": rounded(each.at_s),
                "what": each.what,
                "dip": rounded(each.dip_k),
                "rise": rounded(each.rise_k),
                "recovered_after_s": rounded(each.recovered_after_s),
            }
            for each in figures.disturbances
        ],
    }


def build_json(built: BuildResult) -> dict[str, Any]:
    """Return the object `build` of the JSON: flash, RAM and stack of the binary, in bytes."""
    return {
        "flash": built.flash_bytes,
        "ram": built.ram_bytes,
        "stack": built.stack_bytes,
        "flash_limit": built.flash_limit,
        "ram_limit": built.ram_limit,
    }


def replay_json(results: Iterable[ReplayResult]) -> dict[str, int]:
    """Return the object `replay` of the JSON, over all loops."""
    kept = tuple(results)
    return {
        "ticks": sum(each.ticks for each in kept),
        "mismatches": sum(each.mismatches for each in kept),
    }


def cells(figures: Metrics) -> tuple[str, ...]:
    """Return the figures in the order of COLUMNS."""
    return (
        number(figures.setpoint_c),
        f"{figures.maximum_c:.2f}",
        f"{figures.overshoot_k:+.2f}",
        NONE if figures.settling_s is None else f"{figures.settling_s:.0f}",
        span(figures.steady_minimum_c, figures.steady_maximum_c),
        f"{figures.steady_error_k:.2f}",
        f"{figures.switchings:.0f}" + (" audible" if figures.audible else ""),
        f"{figures.energy_j / 1000:.1f}",
    )


def load_cells(figures: Mapping[str, Metrics]) -> list[tuple[str, ...]]:
    """Return how each loop recovers from disturbances, in the order of LOAD_COLUMNS."""
    return [
        (
            loop,
            each.what,
            number(each.at_s),
            f"{-each.dip_k:.2f}",
            f"{each.rise_k:+.2f}",
            NONE if each.recovered_after_s is None else f"{each.recovered_after_s:.1f}",
        )
        for loop, all_ in figures.items()
        for each in all_.disturbances
    ]


def span(low_c: float, high_c: float) -> str:
    """Write a range of temperatures."""
    return f"{low_c:.2f} … {high_c:.2f}"


def rounded(value: float | None, digits: int = 6) -> float | None:
    """Round away the numerical noise of sums."""
    return None if value is None else round(value, digits)


def finite(value: float) -> float | None:
    """Return a rounded number for JSON; None if it is infinite or NaN, which JSON cannot hold."""
    return rounded(value) if math.isfinite(value) else None
