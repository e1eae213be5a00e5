"""The page with all the evidence for one spec."""

from typing import Any

from heatwright.cli.figures import replay_json
from heatwright.cli.report.chart_data import run_chart
from heatwright.cli.report.pages import data, page, wiring
from heatwright.cli.report.run_page import figures_of
from heatwright.cli.verify.evidence import Evidence
from heatwright.cli.verify.rows import (
    CHAIN_COLUMNS,
    CHECK_COLUMNS,
    FAULT_COLUMNS,
    FIGURE_COLUMNS,
    chain_cells,
    check_cells,
    fault_cells,
    figure_cells,
)
from heatwright.spec.quantity import duration


def verify_page(evidence: Evidence) -> str:
    """Return the page's HTML."""
    controller = evidence.spec.controller
    identity, run = controller.identity, evidence.trials.loops.run
    timing = evidence.trials.timing
    verified = f"{identity.name} on {identity.board}, verified against {evidence.spec.file_name}"
    return page(
        "verify.html.j2",
        identity.title or identity.name,
        subtitle=". ".join([verified, *evidence.unusual]),
        failures=evidence.failures,
        count=evidence.count,
        mismatches=evidence.mismatches,
        tiles=_tiles(evidence),
        data=data(run_chart(run.trace, controller)),
        **figures_of(run),
        check_columns=(*CHECK_COLUMNS, ""),
        check_rows=[(*check_cells(each), _mark(each.passed)) for each in evidence.checks],
        chain_columns=CHAIN_COLUMNS,
        chain_rows=chain_cells(evidence.chains),
        figure_columns=(*FIGURE_COLUMNS, ""),
        figure_rows=[(*figure_cells(each), _mark(each.passed)) for each in timing.figures.values()],
        costs=timing.functions,
        keys="button_to_display_ms" in timing.figures,
        measured=duration(round(timing.seconds)),
        asleep=f"{timing.idle_fraction:.2%}",
        fault_columns=(*FAULT_COLUMNS, ""),
        fault_rows=[(*fault_cells(each), _mark(each.passed)) for each in evidence.trials.faults],
        wiring=wiring(evidence.spec),
        digest=evidence.spec.digest,
    )


def _mark(passed: bool) -> str:
    return "✓" if passed else "✗"


def _tiles(evidence: Evidence) -> list[dict[str, Any]]:
    built, run = evidence.built, evidence.trials.loops.run
    replayed = replay_json(evidence.trials.loops.replays.values())
    used = built.ram_bytes + built.stack_bytes
    return [
        _tile(f"{built.flash_bytes}", f"of {built.flash_limit} bytes of flash",
              built.flash_bytes / built.flash_limit),
        _tile(f"{built.ram_bytes} + {built.stack_bytes}",
              f"static and worst stack, of {built.ram_limit} bytes of RAM", used / built.ram_limit),
        _tile(f"{replayed['mismatches']} mismatches",
              f"in {replayed['ticks']} control steps against the model, bit for bit"),
        _tile(f"{run.speed:.0f} ×", f"real time: {duration(round(run.trace.duration_s))} in "
              f"{run.wall_s:.2f} s"),
    ]  # fmt: skip


def _tile(figure: str, text: str, share: float | None = None) -> dict[str, Any]:
    percent = None if share is None else f"{100 * share:.1f}"
    return {"figure": figure, "text": text, "share": percent}
