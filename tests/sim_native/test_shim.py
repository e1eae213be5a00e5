"""Building and finding the shim, and what is said when it cannot be had."""

import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import pytest

from heatwright.sim.native import SimulatorMissing, shim

BUILD = [sys.executable, "-m", "heatwright.sim.native.build"]


def test_it_is_built_into_the_users_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By several processes at once, whole or not at all, and then found again."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    with ThreadPoolExecutor(3) as pool:
        build = partial(subprocess.run, BUILD, check=True, capture_output=True)
        runs = list(pool.map(lambda _: build(), range(3)))
    assert {run.stderr for run in runs} == {b""}
    (path,) = {Path(run.stdout.decode().strip()) for run in runs}
    assert [path] == list((tmp_path / "heatwright" / "native").iterdir())
    before = path.stat().st_mtime_ns
    assert shim.build() == path
    assert path.stat().st_mtime_ns == before


def headers(folder: Path, version: str) -> Path:
    (folder / "simavr").mkdir(parents=True)
    config = f'#define CONFIG_SIMAVR_VERSION "{version}"\n'
    (folder / "simavr" / "sim_core_config.h").write_text(config)
    return folder


@pytest.fixture
def refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Build with an empty cache; it is refused with these words."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))

    def with_words(words: str) -> None:
        with pytest.raises(SimulatorMissing, match=words):
            shim.build()

    return with_words


Refused = Callable[[str], None]


@pytest.mark.parametrize("version", ["1.5", "1.7", "1.8", "1.60"])
def test_an_untested_simavr_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, refused: Refused, version: str
) -> None:
    monkeypatch.setattr(shim, "HEADERS", (headers(tmp_path, version),))
    refused(f"simavr {version} is untested: install 1.6")


def test_what_is_missing_is_told_with_the_command_that_installs_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, refused: Refused
) -> None:
    with monkeypatch.context() as changed:
        changed.setattr(shim, "HEADERS", (tmp_path,))
        refused(r"^simavr is not installed: sudo apt install .*simavr")
    with monkeypatch.context() as changed:
        changed.setenv("PATH", str(tmp_path))
        refused(r"^There is no C compiler: sudo apt install .*gcc")
    with monkeypatch.context() as changed:
        changed.setattr(shim.sysconfig, "get_paths", lambda: {"include": str(tmp_path)})
        refused("sudo apt install libpython3")


def test_a_shim_that_does_not_compile(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, refused: Refused
) -> None:
    monkeypatch.setattr(shim, "HEADERS", (headers(tmp_path / "include", "1.6"),))
    (tmp_path / "include" / "simavr" / "avr_adc.h").write_text("#error broken\n")
    refused(r"does not compile .*error")
    assert list((tmp_path / "cache" / "heatwright" / "native").iterdir()) == []


def test_a_spoilt_shim(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    spoilt = tmp_path / "spoilt.so"
    spoilt.write_text("not a library")
    monkeypatch.setattr(shim, "build", lambda: spoilt)
    with pytest.raises(SimulatorMissing, match=r"spoilt.so does not load"):
        shim.load.__wrapped__()


def test_a_cache_that_cannot_be_written_is_told_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    surroundings = {"XDG_CACHE_HOME": str(tmp_path / "file")}
    run = subprocess.run(BUILD, env=surroundings, capture_output=True, text=True, check=False)
    assert run.returncode == 1
    assert run.stderr.count("\n") == 1
    assert "set XDG_CACHE_HOME" in run.stderr
