"""Figures of merit, for machines and for people."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from heatwright.generator.toolchain import BuildResult
from heatwright.sim.metrics import Metrics
from heatwright.sim.replay import ReplayResult
from heatwright.spec.quantity import number

NONE = "–"
"""What stands for a figure that there is not."""

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


def as_json(figures: Metrics) -> dict[str, Any]:
    """Return the object `closed_loop` of the JSON; units are °C, K, s and J."""
    return {
        "maximum": rounded(figures.maximum_c),
        "overshoot": rounded(figures.overshoot_k),
        "settling_s": rounded(figures.settling_s),
        "steady_min": rounded(figures.steady_minimum_c),
        "steady_max": rounded(figures.steady_maximum_c),
        "switchings": round(figures.switchings),
        "energy_J": rounded(figures.energy_j, 1),
    }


def build_json(built: BuildResult) -> dict[str, Any]:
    """Return the object `build` of the JSON: what the binary takes, in bytes."""
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


def span(low_c: float, high_c: float) -> str:
    """Write a range of temperatures."""
    return f"{low_c:.2f} … {high_c:.2f}"


def rounded(value: float | None, digits: int = 6) -> float | None:
    """Leave out what is only the noise of adding up."""
    return None if value is None else round(value, digits)
