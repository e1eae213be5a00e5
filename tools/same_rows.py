# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare two results of `verify --json`, number by number: what a quicker simulation may not move.

    heatwright verify chamber.yaml --json > before.json
    heatwright verify chamber.yaml --json --core simavr > now.json
    python tools/same_rows.py before.json now.json

What is different by its nature is left out: the core's name, and the speed. The exit status is 1
where something else is.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

NONE = "nothing"
LEFT_OUT = ("core", "elf", "spec", "speed")


def leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Yield each number, word and truth with where it stands; rows of faults by their names."""
    if path == "/faults":
        value = {f"{each['loop']}.{each['fault']}": each for each in value}
    if isinstance(value, list):
        value = dict(enumerate(value))
    if not isinstance(value, dict) or not value:
        yield path, value
        return
    for key, each in value.items():
        if path or key not in LEFT_OUT:
            yield from leaves(each, f"{path}/{key}")


def main() -> int:
    """Print what is different, and how much was compared."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", nargs=2, type=Path, help="files of verify --json")
    texts = [each.read_text(encoding="utf-8") for each in parser.parse_args().results]
    before, now = (dict(leaves(json.loads(text))) for text in texts)
    different = [each for each in before | now if before.get(each, NONE) != now.get(each, NONE)]
    for each in different:
        print(f"{each}: {before.get(each, NONE)}, {now.get(each, NONE)}")
    rows = {each.split("/")[2] for each in before if each.startswith("/faults/")}
    print(f"{len(rows)} rows of faults and {len(before)} values compared, {len(different)} differ")
    return int(bool(different) or not rows)


if __name__ == "__main__":
    sys.exit(main())
