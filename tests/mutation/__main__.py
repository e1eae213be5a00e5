"""Break the generated C in every small way, and see what the tests notice.

    python -m mutation                          all arenas (run it in tests/)
    python -m mutation host/pid_hold gcode      those whose names begin so
    python -m mutation host --file gate.c       one file
    python -m mutation --list                   what arenas there are
    python -m mutation host --sample 200        as many mutants, drawn always alike

An arena is a firmware and what judges it: `ARENAS` of `tests/*/arena_*.py` (see `arena.py`). A
mutant is `killed` if a judge complains, `equal` if the compiler makes the same machine code of it,
`listed` if equivalent.txt says why nothing can tell it; else it has survived. Verdicts are kept in
build/mutation by the content of all that goes into them: a second run is immediate.

The exit status is 1 if a mutant of protection code survives, or more than 5 % of the others.
"""

import argparse
import json
import sys
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

TESTS = Path(__file__).parents[1]


def main(words: Sequence[str] | None = None) -> int:
    if str(TESTS) not in sys.path:
        sys.path.insert(0, str(TESTS))
    from mutation.engine import Engine, cases_of, every_arena, in_order, sampled  # noqa: PLC0415
    from mutation.report import Report  # noqa: PLC0415

    asked = _parser().parse_args(words)
    arenas = in_order(
        arena for arena in every_arena()
        if not asked.arenas or any(arena.name.startswith(each) for each in asked.arenas)
    )  # fmt: skip
    console = Console(highlight=False, width=None if sys.stdout.isatty() else 160)
    if asked.list:
        for arena in arenas:
            console.print(arena.name)
        return 0
    cases = cases_of(arenas, asked.file)
    cases = sampled(cases, asked.sample) if asked.sample else cases
    report = Report([arena.name for arena in arenas], cases)
    began, fates = time.monotonic(), Counter[str]()

    def tell(case: "Case") -> None:  # noqa: F821
        fates[case.fate] += 1
        if (done := fates.total()) % 50 == 0 or done == len(cases):
            text = f"{done} of {len(cases)}, {fates['survived']} alive"
            print(f"\r{text}, {time.monotonic() - began:.0f} s", end="", file=sys.stderr)

    try:
        Engine(arenas, cases, tell).run(asked.jobs)
    finally:
        print(file=sys.stderr)
    if asked.json:
        asked.json.write_text(json.dumps(report.data(), indent=1, ensure_ascii=False), "utf-8")
    _print(report, console)
    return 0 if report.is_well else 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        "python -m mutation", None, __doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("arenas", nargs="*", help="beginnings of arenas' names")
    parser.add_argument("--file", default="", help="break this file only")
    parser.add_argument("--sample", type=int, default=0, help="so many mutants, not all")
    parser.add_argument("--jobs", type=int, default=0, help="at once; else as many as processors")
    parser.add_argument("--json", type=Path, help="write every mutant and its verdict here")
    parser.add_argument("--list", action="store_true", help="list the arenas")
    return parser


def _print(report: "Report", console: Console) -> None:  # noqa: F821
    table = Table(box=None, pad_edge=False)
    table.add_column("file, function")
    for name in ("mutants", "killed", "equal", "listed", "survived"):
        table.add_column(name, justify="right")
    for file, functions in report.by_file().items():
        table.add_row(file, *map(str, report.counts(functions.values())), style="bold")
        for function, cases in functions.items():
            counts = report.counts([cases])
            if counts[-1]:
                table.add_row(f"  {function or '-'}", *map(str, counts))
    table.add_row("in all", *map(str, report.counts([report.cases])), style="bold")
    console.print(table)
    for line in (*report.survivors(), *report.wrong_entries(), report.verdict()):
        console.print(line, markup=False, soft_wrap=True)


if __name__ == "__main__":
    sys.exit(main())
