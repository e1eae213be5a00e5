"""Building and finding the shim, and what is said when it cannot be had."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from heatwright.sim.native import SimulatorMissing, shim

BUILD = [sys.executable, "-m", "heatwright.sim.native.build"]


def test_it_is_built_into_the_users_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By several processes at once, whole or not at all, and then found again."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    with ThreadPoolExecutor(3) as pool:
        runs = list(
            pool.map(lambda _: subprocess.run(BUILD, check=False, capture_output=True), range(3))
        )
    assert [run.returncode for run in runs] == [0, 0, 0]
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


@pytest.mark.parametrize("version", ["1.5", "1.7", "1.8", "1.60"])
def test_an_untested_simavr_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, version: str
) -> None:
    monkeypatch.setattr(shim, "HEADERS", (headers(tmp_path, version),))
    with pytest.raises(SimulatorMissing, match=f"simavr {version} is untested: install 1.6"):
        shim.build()


def test_no_simavr(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shim, "HEADERS", (tmp_path,))
    with pytest.raises(
        SimulatorMissing, match=r"^simavr is not installed: sudo apt install .*simavr"
    ):
        shim.build()


def test_no_compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(SimulatorMissing, match=r"^There is no C compiler: sudo apt install .*gcc"):
        shim.build()


def test_no_python_headers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(shim.sysconfig, "get_paths", lambda: {"include": str(tmp_path)})
    with pytest.raises(SimulatorMissing, match="sudo apt install libpython3"):
        shim.build()


def test_a_shim_that_does_not_compile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(shim, "HEADERS", (headers(tmp_path / "include", "1.6"),))
    (tmp_path / "include" / "simavr" / "avr_adc.h").write_text("#error broken\n")
    with pytest.raises(SimulatorMissing, match=r"does not compile .*error"):
        shim.build()
    assert list((tmp_path / "cache" / "heatwright" / "native").iterdir()) == []


def test_a_cache_that_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    with pytest.raises(SimulatorMissing, match="set XDG_CACHE_HOME"):
        shim.build()


def test_a_spoilt_shim(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    spoilt = tmp_path / "spoilt.so"
    spoilt.write_text("not a library")
    monkeypatch.setattr(shim, "build", lambda: spoilt)
    with pytest.raises(SimulatorMissing, match=r"spoilt.so does not load"):
        shim.load.__wrapped__()


def test_the_command_says_it_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    run = subprocess.run(
        BUILD,
        env={"XDG_CACHE_HOME": str(tmp_path / "file")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 1
    assert run.stderr.count("\n") == 1
