"""What each size of the suite holds; `suite.toml` beside this file is the one place that says so.

`make test` runs the size "test", `make evidence` the size "evidence", `make evidence SIZE=full`
the size "full". A number (`amount`) has one value for each size. A test has a share for each size:
which part of its cases runs. The cases are drawn by a hash of their names: always the same ones,
until SUITE_SEED says otherwise.
"""

import hashlib
import math
import os
import tomllib
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import pytest

SIZES = ("test", "evidence", "full")
SIZE = os.environ.get("SUITE_SIZE", "test")
SEED = os.environ.get("SUITE_SEED", "0")
TESTS = Path(__file__).parent
TABLE: dict[str, Any] = tomllib.loads((TESTS / "suite.toml").read_text(encoding="utf-8"))


def amount(name: str) -> int:
    """Return how many of something this size of the suite tries, by [amounts] of suite.toml."""
    return int(TABLE["amounts"][name][SIZES.index(SIZE)])


def share_of(test: str) -> float:
    """Return which part of a test's cases is held; `test` is a node id without its parameters.

    The longest entry of [shares] that the id begins with counts; without any, all cases do.
    """
    fitting = [entry for entry in TABLE["shares"] if test.startswith(entry)]
    if not fitting:
        return 1.0
    return float(TABLE["shares"][max(fitting, key=len)][SIZES.index(SIZE)])


def drawn(cases: Sequence[str], share: float) -> set[str]:
    ordered = sorted(cases, key=lambda case: hashlib.sha256(f"{SEED} {case}".encode()).digest())
    return set(ordered[: math.ceil(share * len(ordered))])


def held(nodes: Iterable[str]) -> set[str]:
    """Return those of the node ids that this size holds."""
    tests = defaultdict(list)
    for node in nodes:
        tests[node.partition("[")[0]].append(node)
    chosen: set[str] = set()
    for test, cases in tests.items():
        chosen |= drawn(cases, share_of(test))
    return chosen


def subject_of(node: str) -> str:
    """Return what a test is about, by its folder."""
    folder = node.split("/")[1]
    for subject, folders in TABLE["subjects"].items():
        if folder in folders:
            return str(subject)
    message = f"suite.toml gives the folder tests/{folder} no subject"
    raise LookupError(message)


class Suite:
    """The plugin: deselects what this size does not hold, and sums up what it held."""

    def __init__(self) -> None:
        self.there_are: Counter[str] = Counter()
        self.passed: Counter[str] = Counter()
        self.seconds: Counter[str] = Counter()

    def pytest_collection_modifyitems(
        self, config: pytest.Config, items: list[pytest.Item]
    ) -> None:
        nodes = [item.nodeid for item in items]
        self.there_are = Counter(map(subject_of, nodes))
        if config.option.keyword or any("::" in word for word in config.args):
            return  # whoever names tests gets them
        chosen = held(nodes)
        config.hook.pytest_deselected(items=[item for item in items if item.nodeid not in chosen])
        items[:] = [item for item in items if item.nodeid in chosen]

    @pytest.hookimpl
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Tell the process that collects the results how many tests there are (pytest-xdist)."""
        if hasattr(session.config, "workeroutput"):
            session.config.workeroutput["there_are"] = dict(self.there_are)

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any) -> None:
        self.there_are = Counter(getattr(node, "workeroutput", {}).get("there_are", {}))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        subject = subject_of(report.nodeid)
        self.seconds[subject] += report.duration
        self.passed[subject] += report.when == "call" and report.passed

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        write = terminalreporter.write_line
        terminalreporter.section(f"held, size {SIZE}")
        write(f"{'subject':<44}{'passed':>8}{'of all':>8}{'seconds':>9}")
        for subject in TABLE["subjects"]:
            if self.passed[subject]:
                counts = f"{self.passed[subject]:>8}{self.there_are[subject]:>8}"
                write(f"{subject:<44}{counts}{self.seconds[subject]:>9.0f}")
        total = f"{self.passed.total():>8}{self.there_are.total():>8}{self.seconds.total():>9.0f}"
        write(f"{'in all':<44}{total}")
