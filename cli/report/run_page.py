"""The page of one simulation."""

from typing import Any

from heatwright.cli.figures import COLUMNS, LOAD_COLUMNS, cells, load_cells
from heatwright.cli.report.chart_data import run_chart
from heatwright.cli.report.pages import data, page, picture
from heatwright.cli.results import fault_text
from heatwright.cli.running import Run
from heatwright.spec import Controller
from heatwright.spec.quantity import duration


def run_page(run: Run, controller: Controller, title: str, device: str) -> str:
    """Return the page's HTML; `device` is what was simulated."""
    return page(
        "run.html.j2",
        title,
        subtitle=f"{controller.identity.name}, {duration(round(run.trace.duration_s))} "
        f"simulated with the {device}",
        data=data(run_chart(run.trace, controller)),
        faults=[
            f"{loop}: {fault_text(each)}" for loop, all_ in run.faults.items() for each in all_
        ],
        **figures_of(run),
    )


def figures_of(run: Run) -> dict[str, Any]:
    """Return the values for a page's tables of figures, and for its displays."""
    return {
        "columns": ("loop", *COLUMNS),
        "rows": [(loop, *cells(figures)) for loop, figures in run.figures.items()],
        "load_columns": LOAD_COLUMNS,
        "load_rows": load_cells(run.figures),
        "display": run.display,
        "screen": picture(run.screen),
    }
