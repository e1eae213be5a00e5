"""`heatwright check`: finds the errors of specs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from time import sleep
from typing import TYPE_CHECKING

import click

from heatwright.cli.ends import Refused, Status, unusable
from heatwright.cli.loads import loads, told
from heatwright.cli.options import File, json_option, print_json, with_examples

if TYPE_CHECKING:
    from heatwright.spec import Problem, Spec

LOOK_S = 0.3
"""Time between two checks whether a file was saved."""


@with_examples(
    "heatwright check chamber.yaml kiln.yaml",
    "heatwright check --quick chamber.yaml",
    "heatwright check --watch kiln.yaml",
)
@click.argument("specs", metavar="SPEC...", type=File, nargs=-1, required=True)
@click.option("--quick", is_flag=True, help="Check the text only: do not run the machine.")
@click.option("--watch", is_flag=True, help="Check again whenever a spec is saved; Ctrl-C ends it.")
@json_option
def command(specs: tuple[Path, ...], quick: bool, watch: bool, as_json: bool) -> int:
    """Find all errors of specs.

    Each problem is one line: file, line, column, what is wrong, and what to do about it. If a spec
    describes a machine, the reference model runs it without faults: no protection may trip. Then
    the command prints the power reserve of each heater, the current of each load that is measured
    or rated for less than its supply, and the error that the tolerances of parts cause at each
    sensor on the ADC. It warns of a reserve below 30 %, of parts whose error exceeds the sensor's
    `accuracy`, and of a firmware that certainly does not fit its board.
    """
    if not watch:
        return _checked(specs, quick, as_json)
    if as_json:
        raise Refused("--watch never ends, and --json prints one object: leave out one of them.")
    if Path("-") in specs:
        raise Refused("--watch waits for files to be saved, and - is not a file: name files.")
    for _ in _saves(specs):
        _checked(specs, quick, as_json=False)
        click.echo("Watching …", err=True)
    return Status.DONE


def _saves(specs: tuple[Path, ...]) -> Iterator[None]:
    """Yield at once, and whenever a file was saved; an editor may delete it for a moment."""
    seen: list[tuple[int, int] | None] | None = None
    while True:
        found = [_stamp(path) for path in specs]
        if found != seen:
            seen = found
            yield
        sleep(LOOK_S)


def _stamp(path: Path) -> tuple[int, int] | None:
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size


def _checked(specs: tuple[Path, ...], quick: bool, as_json: bool) -> int:
    from heatwright.cli.budget import budgets_json, show_budgets  # noqa: PLC0415
    from heatwright.cli.sized import reserve_json  # noqa: PLC0415
    from heatwright.spec.physics.effort import sights  # noqa: PLC0415
    from heatwright.spec.physics.reserve import reserves  # noqa: PLC0415

    good: list[tuple[Path, Spec]] = []
    problems: list[Problem] = []
    for path in specs:
        spec, found = _look(path)
        problems += found
        trips = _trips(spec) if spec is not None and not quick else ()
        problems += trips
        if spec is not None and not trips:
            good.append((path, spec))
    if as_json:
        print_json(
            good=[
                {"file": str(path), "digest": spec.digest, "budgets": budgets_json(spec.controller)}
                for path, spec in good
            ],
            loads=[
                {"file": str(path), **each}
                for path, spec in good
                for each in loads(spec.controller)
            ],
            problems=[problem._asdict() for problem in problems],
            reserves=[
                {"file": str(path), **reserve_json(each)}
                for path, spec in good
                for each in reserves(spec.controller)
            ],
            warnings=[each._asdict() for _, spec in good for each in _warnings(spec)],
        )
    else:
        for path, spec in good:
            click.echo(f"{path}: good")
            for reserve in reserves(spec.controller):
                click.echo(f"  {reserve}")
            for sight in sights(spec.controller):
                click.echo(f"  {sight}")
            for load in loads(spec.controller):
                click.echo(f"  {told(load)}")
            show_budgets(spec.controller)
            for warning in _warnings(spec):
                click.echo(f"Warning: {warning}")
        for problem in problems:
            click.echo(str(problem))
    return Status.REFUSED if problems else Status.DONE


def _look(path: Path) -> tuple[Spec | None, tuple[Problem, ...]]:
    """Load a spec, and return its problems: an exception would prevent the check of other files."""
    from heatwright.spec import Problem, SpecError, load  # noqa: PLC0415

    try:
        return load(path), ()
    except SpecError as error:
        return None, error.problems
    except OSError as error:
        reason = f"the file cannot be read: {unusable(error)}"
        remedy = "Name a readable file, or - for standard input"
        unread = Problem(str(path), 1, 1, "", reason, remedy)
        return None, (unread,)


def _trips(spec: Spec) -> tuple[Problem, ...]:
    """Return a problem for each rule that trips in the reference model, which is slow to import."""
    from heatwright.cli.rehearse import rehearsed  # noqa: PLC0415

    return rehearsed(spec)


def _warnings(spec: Spec) -> Iterator[Problem]:
    """Warn of little reserve, inexact parts, no self-checks, and a firmware that cannot fit."""
    from heatwright.cli.budget import too_inexact  # noqa: PLC0415
    from heatwright.cli.sized import small  # noqa: PLC0415
    from heatwright.spec import BOARDS  # noqa: PLC0415
    from heatwright.spec.checks.board.memory import fits, least, rooms  # noqa: PLC0415

    yield from small(spec)
    yield from too_inexact(spec)
    if not spec.controller.safety.self_checks:
        yield spec.tree.problem(
            ("safety", "self_checks"),
            "the controller does not check its own processor, memories and clock: a "
            "damaged controller may heat permanently",
            "Delete self_checks if the chip has room for the checks, about 1,000 B of flash",
        )
    board, taken = spec.controller.board, least(spec.controller)
    if fits(taken, board):
        return
    larger = [name for name, each in BOARDS.items() if fits(taken, each, spare=2)]
    for what, bytes_, room in zip(("flash", "RAM"), taken, rooms(board), strict=True):
        if bytes_ > room:
            yield spec.tree.problem(
                ("controller", "board"),
                f"{what}: at least {bytes_:,} of {room:,} B: {bytes_ - room:,} B too many",
                f"Use a board with more, such as {larger[0]}, or leave something out; "
                "`heatwright build` lists the bytes of each part",
            )
