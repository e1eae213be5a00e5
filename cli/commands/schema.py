"""`heatwright schema`: prints the language as a JSON Schema for editors."""

from heatwright.cli.options import json_option, print_json, with_examples


@with_examples("heatwright schema > heatwright.schema.json")
@json_option
def command(as_json: bool) -> None:
    """Print the language as JSON Schema.

    With it an editor completes and checks specs. An editor with the YAML language server finds it
    by the first line of a spec:
    # yaml-language-server: $schema=heatwright.schema.json
    """
    del as_json  # the schema is JSON with and without it
    from heatwright.spec.loading.schema import schema  # noqa: PLC0415

    print_json(**schema())
