import gc
import os
import signal

# Before numpy is imported: its threads wait by spinning, and would take turns with the tests.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings
from rig.commands import heatwright  # noqa: F401 - a fixture of all tests
from rig.firmware import example
from suite import Suite

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.toolchain import build
from heatwright.spec import Controller
from heatwright.spec.base import ReadOnlyDict

# A job in the background starts with Ctrl-C ignored and hands that down to its children, but some
# tests press it and wait for what it does.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

Vary = Callable[..., Controller]

# The same examples in every run; a clock that a busy machine slows is no reason to fail.
settings.register_profile("repeatable", derandomize=True, deadline=None, database=None)
settings.load_profile("repeatable")


def pytest_configure(config: pytest.Config) -> None:
    config.pluginmanager.register(Suite(), "suite")


def pytest_collection_finish() -> None:
    """Look for garbage seldom, and not in what lives as long as the run: 3 % of its time."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(10_000, 10, 10)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Where CI=true, a test that is skipped has failed: nothing was shown."""
    report = yield
    if report.skipped and os.environ.get("CI") == "true":
        report.outcome = "failed"
    return report


@pytest.fixture(scope="session")
def chamber() -> Controller:
    return example("chamber").controller


@pytest.fixture(scope="session")
def chamber_elf(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The chamber's binary, as PlatformIO builds it; built once, then taken from the cache."""
    project = tmp_path_factory.mktemp("chamber")
    write(render(plan_firmware(example("chamber"))), project)
    return build(project).elf


@pytest.fixture(scope="session")
def oven() -> Controller:
    return example("oven").controller


@pytest.fixture(scope="session")
def vary(chamber: Controller) -> Vary:
    """The chamber with another algorithm, output, period, or other protections."""

    def varied(
        *, algorithm: Any = None, output: Any = None, period_s: float = 1.0, **protection: Any
    ) -> Controller:
        loop = chamber.loops["air"]
        changes = {"algorithm": algorithm or loop.algorithm, "period_s": period_s}
        kept = loop.protection.model_copy(update=protection)
        changed = loop.model_copy(update={**changes, "protection": kept})
        outputs = {**chamber.outputs, "heater": output or chamber.outputs["heater"]}
        return chamber.model_copy(
            update={"loops": ReadOnlyDict({"air": changed}), "outputs": ReadOnlyDict(outputs)}
        )

    return varied
