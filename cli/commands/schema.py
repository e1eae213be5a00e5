"""`heatwright schema`: the language, for editors."""

from __future__ import annotations

import click

from heatwright.cli.command import Command
from heatwright.cli.options import json_option, print_json


@click.command(
    cls=Command,
    examples=("heatwright schema > heatwright.schema.json",),
)
@json_option
def command(as_json: bool) -> None:
    """Print the language as JSON Schema.

    With it an editor completes and checks specs. An editor with the YAML language server finds it
    by the first line of a spec:
    # yaml-language-server: $schema=heatwright.schema.json
    """
    del as_json  # the schema is JSON with and without it
    from heatwright.spec.loading.schema import schema  # noqa: PLC0415

    print_json(schema())
