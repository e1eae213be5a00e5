"""`heatwright size`: computes the power that a machine needs, and its heater's wire."""

from pathlib import Path

import click

from heatwright.cli.ends import Refused
from heatwright.cli.options import json_option, print_json, spec_argument, with_examples


@with_examples("heatwright size chamber.yaml", "heatwright size chamber.yaml --json")
@spec_argument
@json_option
def command(spec: Path, as_json: bool) -> None:
    """Compute the power that each heater needs.

    It is the power that holds the highest setpoint in the spec's plant. If the spec's simulation
    has `sizing`, the command also prints the heat through the walls (from area, thickness,
    conductivity, wind, radiation), and diameter, length, current and temperature of the heater's
    wire (from resistivity, voltage, surface load).
    """
    from heatwright.cli.sized import rows, sized, sized_json, small  # noqa: PLC0415
    from heatwright.cli.tables import heading, show, table  # noqa: PLC0415
    from heatwright.spec import load  # noqa: PLC0415

    loaded = load(spec)
    controller = loaded.controller
    if controller.simulation is None:
        raise Refused(f"{spec} has no machine to size a heater for. Add a section simulation.")
    found = list(sized(controller))
    if as_json:
        loops = {each.reserve.loop: sized_json(each) for each in found}
        warnings = [each._asdict() for each in small(loaded)]
        print_json(spec=str(spec), digest=loaded.digest, loops=loops, warnings=warnings)
        return
    for each in found:
        heading(f"{controller.identity.name}, loop {each.reserve.loop}")
        show(table(("what", "value", "unit"), rows(each)))
    for warning in small(loaded):
        click.echo(f"Warning: {warning}")
