# SPDX-License-Identifier: GPL-3.0-or-later
"""How fast it is here, in ratios: to the yard, to other simulators, to ESPHome; `make bench`.

    python tools/bench [PART …] [--times N] [--against CHECKOUT] [--page]

A yard is the processor time of 10⁷ additions in a plain Python loop. Each part measures its own,
and what it compares takes turns. The figures are kept in build/bench.json; with --page they become
docs/benchmarks.md and its picture. It judges nothing: a slow machine is no fault of the program.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from campaigns import campaigns
from cores import cores
from growth import growth
from measure import ROOT, machine
from page import PICTURE, page
from picture import draw
from proof import loops, verified
from seat import seat
from startup import startup

KEPT = ROOT / "build" / "bench.json"
PAGE = ROOT / "docs" / "benchmarks.md"


def main() -> None:
    """Measure, keep, print; write the page if it is asked for."""
    asked = arguments()
    parts: dict[str, Callable[[], Any]] = {
        "startup": lambda: startup(5 * asked.times),
        "verify": lambda: verified(asked.times, tell),
        "loops": lambda: loops(asked.times, tell, asked.against),
        "cores": lambda: cores(asked.times, tell, asked.share),
        "growth": lambda: growth(asked.times, tell),
        "campaigns": lambda: campaigns(asked.times, tell),
        "seat": lambda: seat(asked.times, tell),
    }
    found = json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}
    for part in asked.parts or parts:
        tell(part)
        found |= {"machine": machine(), part: parts[part]()}
        KEPT.parent.mkdir(exist_ok=True)
        KEPT.write_text(json.dumps(found, indent=1), encoding="utf-8")
    print(page(found))
    if asked.page:
        PAGE.write_text(page(found), encoding="utf-8")
        draw(found, PAGE.with_name(PICTURE))
        tell(f"{PAGE} and {PICTURE} are written")


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(prog="bench", description=__doc__.splitlines()[0])
    names = ("startup", "verify", "loops", "cores", "growth", "campaigns", "seat")
    parser.add_argument("parts", nargs="*", choices=[*names, []], help="what to measure; all")
    parser.add_argument("--times", type=int, default=3, help="of which the quickest counts")
    parser.add_argument("--share", type=float, default=1.0, help="of the processor's usual run")
    parser.add_argument("--against", type=Path, help="another checkout, set up, for its loops")
    parser.add_argument("--page", action="store_true", help="write docs/benchmarks.md")
    return parser.parse_args()


def tell(text: str) -> None:
    """Say what is done."""
    print(f"  {text}", flush=True)


if __name__ == "__main__":
    main()
