"""`make bench`: its machines are good, what is missing is told, the page says what was measured."""

import json
import sys
from pathlib import Path
from typing import Any

import pytest
from rig.firmware import EXAMPLES, ROOT, finished

from heatwright.spec import load

BENCH = ROOT / "tools" / "bench"
STARTUP = {
    "yard_s": 0.5, "lines": {"ours": 57, "theirs": 56}, "esphome": {},
    "ours": {"--help": 0.1, "check --quick": 0.3, "generate": 0.4},
}  # fmt: skip
HOST = {"machine": {"processor": "One", "cores": 2, "python": "3.11.7"}}


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Any:
    known = set(sys.modules)
    monkeypatch.syspath_prepend(BENCH)
    yield __import__
    for name in set(sys.modules) - known:
        if str(getattr(sys.modules[name], "__file__", "")).startswith(str(BENCH)):
            del sys.modules[name]


def test_the_fewest_chambers_and_the_most_are_good_specs(bench: Any, tmp_path: Path) -> None:
    growth = bench("growth")
    for count in (min(growth.LOOPS), max(growth.LOOPS)):
        path = tmp_path / f"{count}.yaml"
        path.write_text(json.dumps(growth.chambers(count)), encoding="utf-8")
        controller = load(path).controller
        assert (len(controller.loops), len(controller.simulation.plant.nodes)) == (count, 3 * count)


def test_what_is_missing_is_told_and_left_out(
    bench: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    cores, startup = bench("cores"), bench("startup")
    monkeypatch.setattr(cores, "AVR8JS", tmp_path / "no")
    monkeypatch.setattr(startup, "ESPHOME", tmp_path / "no")
    assert list(cores.available(tmp_path)) == ["heatwright", "heatwright --core simavr", "simavr"]
    assert not [name for name in startup.commands(tmp_path) if name.startswith("esphome")]
    assert capsys.readouterr().out.count("make peers installs") == 2


def test_all_run_an_image_to_its_end(bench: Any, tmp_path: Path) -> None:
    cores = bench("cores")
    image, _ = cores.images(tmp_path)["sleeps, 1 kHz tick"]
    for name, run in cores.available(tmp_path).items():
        assert run(image, 0.2) > 0, name


def test_the_page_tells_ratios(bench: Any) -> None:
    page = bench("page").page
    alone = page({**HOST, "startup": STARTUP})
    assert "One, 2 cores, Python 3.11.7" in alone
    assert "| `--help` | 0.20 | – | – |" in alone
    assert "| `generate` | 0.80 | – | – |" in alone
    beside = page({**HOST, "startup": {**STARTUP, "esphome": {"config": 0.6}}})
    assert "| `check --quick` | 0.60 | `config`: 1.20 | 0.50 |" in beside
    loops = {"yard_s": 0.5, "kiln": {"now": {"speed": 1000.0, "limit": 4000.0, "in_c": 0.8}}}
    assert "| kiln | 1,000 | 4,000 | 7.2 | 25% | 55% | 20% |" in page({**HOST, "loops": loops})
    loops["kiln"]["before"] = {"speed": 400.0, "limit": None}
    told = page({**HOST, "loops": loops})
    assert "| kiln | 1,000 | 4,000 | 7.2 | 25% | 55% | 20% | 2.50 |" in told
    cores = {"tick": {"heatwright": 300.0, "simavr": 200.0, "avr8js": 4.0}}
    assert "| tick | 300 | 200 | 4 | 1.5 |" in page({**HOST, "cores": cores})
    took = {"1": {"processor_s": 20.0, "wall_s": 25.0}, "2": {"processor_s": 22.0, "wall_s": 12.5}}
    told = page({**HOST, "campaigns": {"yard_s": 0.5, "runs": 100, "processes": took}})
    assert "| 1 | 400 | 500 | 1.00 |" in told
    assert "| 2 | 440 | 250 | 2.00 |" in told
    keys = {"keys": 60, "key_median_ms": 68.4, "key_most_ms": 84}
    watched = {"hours": 8, "times": 3, "watched_s": 2.0, "simulated_s": 1.5}
    told = page({**HOST, "seat": keys | watched})
    assert "68 ms by the clock on the wall (median of 60 keys; at most 84 ms)" in told
    assert "goes at 0.75 times the speed" in told
    assert page({**HOST, "seat": {}}) == page(HOST), "what was not measured is left out"


@pytest.mark.parametrize(("peak", "status"), [(71.5, 0), (71.6, 1)])
def test_results_are_compared_row_by_row(peak: float, status: int, tmp_path: Path) -> None:
    results = {"before": ("own", 71.5), "now": ("simavr", peak)}
    for name, (core, peak_c) in results.items():
        row = {"fault": "unplugged", "loop": "air", "peak": peak_c, "passed": True}
        found = {"core": core, "faults": [row], "speed": {"wall_s": peak_c}, "passed": True}
        (tmp_path / name).write_text(json.dumps(found), encoding="utf-8")
    tool = [sys.executable, BENCH.parent / "same_rows.py", *(tmp_path / each for each in results)]
    done = finished(tool)
    assert done.returncode == status
    assert f"1 rows of faults and 5 values compared, {status} differ" in done.stdout
    assert ("/faults/air.unplugged/peak: 71.5, 71.6" in done.stdout) is bool(status)


def test_the_specs_that_are_measured_are_there(bench: Any) -> None:
    proof = bench("proof")
    assert all((EXAMPLES / f"{name}.yaml").is_file() for name in proof.VERIFIED + proof.LOOPS)
