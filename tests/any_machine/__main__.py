"""Draw machines, and verify each that `check` calls good.

    python -m any_machine --count 200        draw 200 (run it in tests/; or: make drawn N=200)
    python -m any_machine --only 17          the 17th alone: its spec, each check as it comes
    python -m any_machine --only 17 jump_up  the same with these faults alone
    python -m any_machine --faults 5         some faults of each, drawn always alike, not all
    python -m any_machine --json drawn.json  write each machine and what was found of it

A machine is the same one whenever its number is drawn, unless SUITE_SEED says otherwise. Those that
take many minutes to simulate are drawn with SUITE_SIZE=full alone; a number is then another
machine. Nothing is kept from run to run. Ctrl-C ends it with the counts so far. The exit status is
1 if one is red.
"""

import argparse
import json
import os
import re
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

INTERRUPTED = 130

Found = dict[str, Any]


def main(words: Sequence[str] | None = None) -> int:
    asked = _parser().parse_args(words)
    if asked.only is not None:
        return _one(asked.only, asked.fault)
    from any_machine.drawing import verify  # noqa: PLC0415
    from rig.verified import Silent  # noqa: PLC0415

    from heatwright.cli.pool import spread  # noqa: PLC0415

    found: list[Found] = []

    def came(each: Found) -> None:
        found.append(each)
        _progress(found, asked.count)
        _write(found, asked.json)

    status = 0
    pieces = [(number, asked.faults) for number in range(asked.first, asked.first + asked.count)]
    try:
        spread(verify, pieces, [Silent()] * len(pieces), came=came, most=asked.jobs)
    except KeyboardInterrupt:
        status = INTERRUPTED
    print(file=sys.stderr)
    _print(found)
    return status or int(any(each["end"] == "red" for each in found))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        "python -m any_machine", None, __doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("fault", nargs="*", help="with --only: ids of the faults that are tried")
    parser.add_argument("--count", type=int, default=20, help="how many are drawn (20)")
    parser.add_argument("--first", type=int, default=0, help="number of the first (0)")
    parser.add_argument("--only", type=int, help="number of the one that is looked at alone")
    parser.add_argument("--faults", type=int, help="how many faults of each; else all")
    parser.add_argument("--jobs", type=int, help="at once; else as many as processors")
    parser.add_argument("--json", type=Path, help="write what was found here")
    return parser


def _one(number: int, faults: Sequence[str]) -> int:
    from any_machine.drawing import machine  # noqa: PLC0415
    from rig.verified import verified  # noqa: PLC0415

    drawn = machine(number)
    print(drawn.text)
    verdict = verified(drawn.spec, list(faults) or None, lambda line: print(line, flush=True))
    if not verdict.fits:
        print("does not fit its board")
    return int(bool(verdict.red))


def _cause(name: str) -> str:
    """Call it the same, whichever loop and corner it is of."""
    return re.sub(r"^\w+[.:] ?", "", re.sub(r"healthy_\d.*", "healthy", name))


def _summary(found: Sequence[Found]) -> Found:
    causes = Counter(_cause(name) for each in found for name, _ in each["red"])
    return {
        "drawn": len(found),
        **Counter(each["end"] for each in found),
        "told_by_check": sum(len(each["refused"]) for each in found),
        "mended_as_told": sum(bool(each["told"]) for each in found),
        "causes": dict(causes.most_common()),
        "machines": sorted(found, key=lambda each: each["number"]),
    }


def _write(found: Sequence[Found], path: Path | None) -> None:
    if path is not None:
        path.write_text(json.dumps(_summary(found), indent=1, ensure_ascii=False), "utf-8")


def _progress(found: Sequence[Found], count: int) -> None:
    for name, detail in found[-1]["red"]:
        print(f"\r{found[-1]['number']:>5}  {name}: {detail}", file=sys.stderr)
    reds = sum(each["end"] == "red" for each in found)
    print(f"\r{len(found)} of {count}, {reds} red", end="", file=sys.stderr, flush=True)


def _print(found: Sequence[Found]) -> None:
    summary = _summary(found)
    for each in summary["machines"]:
        for name, detail in each["red"]:
            print(f"{each['number']:>5}  {name}: {detail}")
    for what in ("drawn", "verified", "red", "does not fit", "told_by_check", "mended_as_told"):
        print(f"{what.replace('_', ' '):<14}{summary.get(what, 0):>6}")
    for cause, times in summary["causes"].items():
        print(f"  red by {cause:<24}{times:>6}")


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its threads would wait by spinning
    sys.exit(main())
