"""`heatwright verify`: gathers all evidence for one spec."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from heatwright.cli.ends import Status
from heatwright.cli.firmware import told_as_json
from heatwright.cli.options import File, json_option, print_json, spec_argument, with_examples
from heatwright.cli.talk import talk
from heatwright.cli.targets import check_target, whole

if TYPE_CHECKING:
    from heatwright.sim.avr import Core


MOST_UPSETS = 1_000_000


@with_examples(
    "heatwright verify chamber.yaml",
    "heatwright verify chamber.yaml --report chamber.html",
    "heatwright verify chamber.yaml --json > evidence.json",
    "heatwright verify chamber.yaml --fault jump_up --fault power_cut",
    "heatwright verify chamber.yaml --core simavr",
    "heatwright verify chamber.yaml --upsets 1000",
    "heatwright verify chamber.yaml --upsets 1 --first 380",
    "heatwright verify chamber.yaml --elf .pio/build/firmware/firmware.elf",
)
@spec_argument
@click.option("--scenario", type=File, help="Take the scenario from this file.")
@click.option("--report", type=File, metavar="OUT.html", help="Write all results as one HTML file.")
@click.option(
    "--core",
    type=click.Choice(("own", "simavr")),
    default="own",
    show_default=True,
    help="Simulator core that runs the instructions: heatwright's own, or simavr's (slower).",
)
@click.option(
    "--elf",
    type=File,
    metavar="FILE",
    help="Build nothing: verify this binary, built elsewhere from the sources of this spec.",
)
@click.option(
    "--fault",
    "only",
    multiple=True,
    metavar="FAULT",
    help="Try only this fault; can be given several times.",
)
@click.option(
    "--upsets",
    type=click.IntRange(0, MOST_UPSETS),
    default=0,
    show_default=True,
    metavar="N",
    help="Flip N bits of RAM, registers, EEPROM and flash, one at a time, at random moments.",
)
@click.option(
    "--first",
    type=click.IntRange(0, 2**31 - 1),
    default=0,
    show_default=True,
    metavar="NUMBER",
    help="Number of the first upset, to repeat it.",
)
@click.option(
    "--seed",
    type=click.IntRange(0, 2**31 - 1),
    default=1,
    show_default=True,
    metavar="SEED",
    help="Seed of the random upsets.",
)
@json_option
def command(  # noqa: PLR0913, PLR0917 - one for each option
    spec: Path,
    report: Path | None,
    core: Core,
    elf: Path | None,
    only: tuple[str, ...],
    upsets: int,
    first: int,
    seed: int,
    scenario: Path | None,
    as_json: bool,
) -> int:
    """Prove that the firmware does what the spec says.

    Generates and builds the firmware, runs the unmodified binary against the simulated machine,
    repeats each of its control steps with the reference model (every variable must be equal, bit
    for bit), injects the faults that its protections must detect, and measures its timing.

    Exit status: 0 all checks hold, 1 a check fails.
    """
    check_target(report, (".html",))
    from heatwright.cli.verify.engine import Upsets, verify  # noqa: PLC0415
    from heatwright.spec import load  # noqa: PLC0415

    loaded = load(spec)
    if scenario is not None:
        from heatwright.cli.beside import with_scenario  # noqa: PLC0415

        loaded = loaded._replace(controller=with_scenario(loaded, scenario, None))
    keys = {"core": core, "elf": elf and str(elf), "passed": False}
    with told_as_json(as_json, spec, loaded, **keys), talk() as shown:
        tried = Upsets(range(first, first + upsets), seed)
        evidence = verify(str(spec), loaded, shown, core=core, elf=elf, upsets=tried, only=only)
    if report is not None:
        from heatwright.cli.report.verify_page import verify_page  # noqa: PLC0415

        with whole(report) as fresh:
            fresh.write_text(verify_page(evidence), encoding="utf-8")
    if as_json:
        print_json(**evidence.as_json())
    else:
        from heatwright.cli.verify.shown import print_evidence  # noqa: PLC0415

        print_evidence(evidence)
        if report is not None:
            click.echo(str(report))
    return Status.DONE if evidence.passed else Status.FAILED
