"""Sensors, faults, timing and checks as rows of tables, without their verdicts."""

from collections.abc import Iterable

from heatwright.cli.figures import NONE
from heatwright.cli.verify.checks import Check
from heatwright.sim.chain import ChainError
from heatwright.sim.faults import FaultResult
from heatwright.sim.timing import Figure

CHECK_COLUMNS = ("", "limit", "found")
CHECK_TEXTS = 3
CHAIN_COLUMNS = ("sensor", "at", "one step of the ADC", "largest error near")
CHAIN_UNITS = {"temperature": ("°C", "K", 0), "current": ("A", "A", 1)}
"""For each quantity: unit, unit of differences, and number of decimals."""
FAULT_COLUMNS = ("fault", "trips", "would trip next", "after [s]", "heater off [s]", "peak [°C]")
FAULT_TEXTS = 3
FIGURE_COLUMNS = ("", "in", "worst", "limit")
FIGURE_TEXTS = 2


def check_cells(check: Check) -> tuple[str, ...]:
    """Return a check's row in the order of CHECK_COLUMNS."""
    return check.what, check.limit, check.found


def chain_cells(chains: Iterable[ChainError]) -> list[tuple[str, ...]]:
    """Return the rows of all sensors in the order of CHAIN_COLUMNS."""
    return [
        (
            chain.sensor,
            f"{row.at:.{decimals}f} {unit}",
            f"{row.step:.3f} {difference}",
            f"{row.error:.3f} {difference}",
        )
        for chain in chains
        for unit, difference, decimals in (CHAIN_UNITS[chain.measures],)
        for row in chain.rows
    ]


def fault_cells(result: FaultResult) -> tuple[str, ...]:
    """Return a fault's row in the order of FAULT_COLUMNS."""
    nothing = "nothing, as it must be" if result.calm else "no rule is met"
    if not result.passed:
        nothing = "nothing"
    others = [rule for rule in result.counting if rule != result.rule]
    return (
        result.fault.replace("_", " "),
        (result.rule or nothing).replace("_", " "),
        ", ".join(others).replace("_", " ") or NONE,
        _seconds(result.tripped_after_s),
        _seconds(result.heater_off_after_s),
        f"{result.peak_c:.1f}",
    )


def figure_cells(figure: Figure) -> tuple[str, ...]:
    """Return a timing figure's row in the order of FIGURE_COLUMNS."""
    worst = NONE if figure.worst is None else f"{figure.worst:.4g} {figure.unit}"
    return figure.what, figure.where or "", worst, f"{figure.limit:g} {figure.unit}"


def _seconds(value: float | None) -> str:
    return NONE if value is None else f"{value:.2f}"
