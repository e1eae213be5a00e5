"""The results of a campaign as text and as JSON data."""

import shlex
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from heatwright.cli.campaign.summary import QUANTILE_NAMES, Quantiles, Summary
from heatwright.cli.figures import NONE, as_json, rounded
from heatwright.sim.campaign.outcome import CAUGHT, TRIPPED, UNNOTICED, WELL, Outcome
from heatwright.sim.campaign.vary import Vary
from heatwright.spec import Spec

WORDS = {
    WELL: "nothing broke, nothing tripped",
    TRIPPED: "nothing broke, and a rule tripped",
    CAUGHT: "something broke, and a rule tripped",
    UNNOTICED: "something broke, and no rule tripped",
}
SPREAD_COLUMNS = ("runs", *QUANTILE_NAMES)


@dataclass(frozen=True)
class Campaign:
    """A finished campaign.

    computed -- number of runs that this command has computed; the others were there before.
    """

    spec: Spec
    file: Path
    vary: Vary
    vary_file: Path | None
    seed: int
    folder: Path
    table: Path
    computed: int
    wall_s: float
    summary: Summary

    def command(self, run: int) -> str:
        """Return the command that repeats one run."""
        words = ["heatwright", "campaign", str(self.file)]
        words += ["--vary", str(self.vary_file)] if self.vary_file is not None else []
        words += ["--seed", str(self.seed)] if self.seed else []
        return shlex.join([*words, "--only", str(run)])


def vary_text(vary_file: Path | None) -> str:
    """Say which variations are used: the file's, or those for any machine."""
    return "defaults for any machine" if vary_file is None else str(vary_file)


def spread_cells(each: Quantiles) -> tuple[str, ...]:
    """Return one row of a table of quantiles, in the order of SPREAD_COLUMNS."""
    name = f"{each.what} [{each.unit}]" if each.unit else each.what
    runs = str(each.having) if each.having == each.of else f"{each.having} of {each.of}"
    values = [f"{value:.4g}" for value in each.values] or [NONE] * len(QUANTILE_NAMES)
    return name, runs, *values


def worst_cells(done: Campaign) -> list[tuple[str, ...]]:
    """Return the rows of the table of the worst runs."""
    return [(each.what, each.value, done.command(each.run)) for each in done.summary.worst]


def summary_json(done: Campaign) -> dict[str, Any]:
    """Return the summary as JSON data."""
    summary = done.summary

    def spreads(all_: Iterable[Quantiles]) -> list[dict[str, Any]]:
        return [
            {
                "what": each.what, "unit": each.unit, "runs": each.having, "of": each.of,
                **dict(zip(QUANTILE_NAMES, map(rounded, each.values), strict=False)),
            }
            for each in all_
        ]  # fmt: skip

    return {
        "spec": str(done.file),
        "digest": done.spec.digest,
        "vary": [list(line) for line in done.vary.lines()],
        "seed": done.seed,
        "runs": summary.runs,
        "computed": done.computed,
        "outcomes": summary.outcomes,
        "rules": summary.rules,
        "too_hot": summary.too_hot,
        "figures": spreads(summary.figures),
        "peaks": spreads(summary.peaks),
        "trips": spreads(summary.trips),
        "worst": [{**each._asdict(), "command": done.command(each.run)} for each in summary.worst],
        "table": str(done.table),
        "wall_s": rounded(done.wall_s),
    }


def print_summary(done: Campaign) -> None:
    """Print the summary as text."""
    from heatwright.cli.tables import console, heading, show, table  # noqa: PLC0415

    summary = done.summary
    heading(f"{done.spec.controller.identity.name}: {summary.runs} runs, seed {done.seed}")
    print_varied(done.vary, done.vary_file)
    out = console()
    for word, count in summary.outcomes.items():
        bad = count and word in {TRIPPED, UNNOTICED}
        out.print(f"  {count:6d}  {WORDS[word]}", style="red" if bad else "", markup=False)
    for rule, count in summary.rules.items():
        out.print(f"          {rule}: {count}", style="red", markup=False)
    for node, count in summary.too_hot.items():
        told = f"  {count:6d}  {node} became hotter than `bears` allows"
        out.print(told, style="red", markup=False)
    for title, rows in (
        ("runs without a fault", summary.figures),
        ("highest temperature, all runs", summary.peaks),
        ("time to trip", summary.trips),
    ):
        if rows:
            show(table((title, *SPREAD_COLUMNS), map(spread_cells, rows)))
    show(table(("worst", "", "repeat the run"), worst_cells(done), text_columns=3))
    click.echo(f"{done.table}: {summary.runs} rows, {done.computed} of them computed now")


def print_varied(vary: Vary, vary_file: Path | None) -> None:
    """Print what varies and how."""
    click.echo(f"Varied, by {vary_text(vary_file)}:")
    for key, text in vary.lines():
        click.echo(f"  {key}: {text}")


# -- a single run ----------------------------------------------------------------------------------


def run_json(file: Path, spec: Spec, seed: int, one: Outcome) -> dict[str, Any]:
    """Return a single run as JSON data."""
    return {
        "spec": str(file), "digest": spec.digest, "seed": seed, "row": one.row,
        "loops": {loop: as_json(figures) for loop, figures in one.figures.items()},
    }  # fmt: skip


def print_run(spec: Spec, seed: int, one: Outcome) -> None:
    """Print a single run as text."""
    from heatwright.cli.tables import heading, show, show_figures, table  # noqa: PLC0415

    row = one.row
    heading(f"{spec.controller.identity.name}, run {row['run']} of seed {seed}")
    click.echo(f"  {WORDS[str(row['outcome'])]}")
    if row["rule"] is not None:
        after = row["tripped_after_s"]
        since = f", {after:.1f} s after something broke" if isinstance(after, float) else ""
        click.echo(f"  {row['rule']} tripped at {row['tripped_s']:.1f} s{since}")
    if row["too_hot"] is not None:
        click.echo(f"  {row['too_hot']} became hotter than `bears` allows")
    drawn = [(name, row[name]) for name in row if name.startswith(("drawn.", "peak."))]
    show(table(("", "value"), [(name, _cell(value)) for name, value in drawn]))
    show_figures(one.figures)


def _cell(value: object) -> str:
    if value is None:
        return NONE
    return f"{value:.5g}" if isinstance(value, float) else str(value)
