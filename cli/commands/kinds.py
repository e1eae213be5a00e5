"""`heatwright kinds`: the kinds that a spec may name, their packages, and missing pieces."""

import click

from heatwright.cli.ends import Status
from heatwright.cli.options import json_option, print_json, with_examples


@with_examples("heatwright kinds", "heatwright kinds --json")
@json_option
def command(as_json: bool) -> int:
    """List the kinds that a spec may name, and who provides them.

    They are kinds of sensors, outputs, algorithms, interfaces and plants. Packages that are
    installed beside heatwright may provide more of them. For these the command lists each piece
    that is missing, and its file.

    Exit status: 0 nothing is missing, 1 something is.
    """
    from heatwright.cli.contract import UNIONS, lacking  # noqa: PLC0415
    from heatwright.cli.tables import show, table  # noqa: PLC0415
    from heatwright.spec import kinds  # noqa: PLC0415
    from heatwright.spec.registry import brought, misnamed  # noqa: PLC0415

    listed = [
        {
            "role": role,
            "kind": kind,
            "package": brought(role)[kind].package if kind in brought(role) else "heatwright",
            "lacks": list(lacking(role, kind)) if kind in brought(role) else [],
        }
        for role, union in UNIONS.items()
        for kind in dict.fromkeys([*kinds(union), *brought(role)])
    ]
    others = misnamed()
    if as_json:
        print_json(kinds=listed, misnamed=others)
    else:
        rows = [(str(each["role"]), str(each["kind"]), str(each["package"])) for each in listed]
        show(table(("role", "kind", "package"), rows, text_columns=3))
        for line in (*others, *(line for each in listed for line in each["lacks"])):
            click.echo(line)
    bad = others or any(each["lacks"] for each in listed)
    return Status.FAILED if bad else Status.DONE
