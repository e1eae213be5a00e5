"""Campaigns of a short chamber: the same rows whoever runs them, kept, and shown. At the end of the
file, on a real Dask scheduler and its workers, on this computer."""

import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest
from distributed import Client
from pyarrow import parquet
from rig.commands import Heatwright
from rig.firmware import EXAMPLE_NAMES, EXAMPLES, changed, example, finished

from heatwright.cli.campaign.given import given
from heatwright.cli.campaign.work import GOES_ON, Task, run_here, run_whole
from heatwright.cli.ends import Refused
from heatwright.cli.pool import processes
from heatwright.sim.binary.elf import Elf
from heatwright.sim.campaign.breaks import BREAKS
from heatwright.sim.campaign.drawn import draw
from heatwright.sim.campaign.outcome import outcome
from heatwright.sim.campaign.vary import Vary, vary_of
from heatwright.sim.campaign.world import DrawnWorld
from heatwright.sim.machine import FEED, TIPS
from heatwright.sim.plants import plant_of
from heatwright.spec import Controller, Event

VARY = """\
capacities: {all: ± 20 %, walls: normal 5 %}
resistances: {air-walls: 0.15 K/W .. 0.2 K/W}
ambient: [15 °C, 20 °C, 25 °C]
supply: ± 10 %
errors: {air: ± 0.5 K}
noise: {air: 0 K .. 0.2 K}
late: 0 s .. 5 s
asks:
  - {loop: air, at: 20 s .. 25 s, setpoint: 30 °C .. 60 °C, chance: 50 %}
upsets:
  - {at: 30 s, node: air, by: -5 K .. -2 K}
  - {at: 35 s, power_cut: 1 s .. 2 s, chance: 50 %}
faults: {chance: 40 %, at: 20 s .. 30 s}
"""


def short_chamber(length: str = "1 min") -> str:
    """Write short.yaml, the chamber with a short scenario, and vary.yaml; return what to type."""
    text = changed("chamber", ("for: 30 min", f"for: {length}"))
    Path("short.yaml").write_text(text, encoding="utf-8")
    Path("vary.yaml").write_text(VARY, encoding="utf-8")
    return "campaign short.yaml --vary vary.yaml"


def kept(folder: str) -> int:
    file = Path(folder, "runs.jsonl")
    return file.read_bytes().count(b"\n") if file.is_file() else 0


def wait_for(condition: Callable[[], object], what: str, of: subprocess.Popen[Any]) -> None:
    """Wait until something is so, as long as a process is there, for four minutes at most."""
    end_s = time.monotonic() + 240
    while not condition():
        assert of.poll() is None, f"{what}: it has ended"
        assert time.monotonic() < end_s, what
        time.sleep(0.05)


PROGRAM = [sys.executable, "-m", "heatwright.cli.start"]


def table(folder: str) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = parquet.read_table(f"{folder}/runs.parquet").to_pylist()
    return rows


def with_scenario(controller: Controller, *events: dict[str, Any]) -> Controller:
    scenario = tuple(map(Event.model_validate, events))
    simulation = controller.simulated.model_copy(update={"scenario": scenario})
    return controller.model_copy(update={"simulation": simulation})


def test_the_same_bytes_from_one_thread_from_two_processes_and_in_two_goes(
    heatwright: Heatwright,
) -> None:
    line = short_chamber()
    alone = heatwright(f"{line} --runs 6 --processes 1 -o alone --json").json
    assert (alone["runs"], alone["computed"], sum(alone["outcomes"].values())) == (6, 6, 6)
    assert heatwright(f"{line} --runs 6 --processes 2 -o two --json").json["computed"] == 6
    heatwright(f"{line} --runs 2 --processes 1 -o goes")
    journal = Path("goes/runs.jsonl")
    journal.write_bytes(journal.read_bytes() + b'{"run":2,"outco')  # the power went
    grown = heatwright(f"{line} --runs 6 --processes 1 -o goes --json").json
    assert grown["computed"] == 4
    assert heatwright(f"{line} --runs 6 -o goes --json").json["computed"] == 0
    expected = Path("alone/runs.parquet").read_bytes()
    for folder in ("two", "goes"):
        assert Path(f"{folder}/runs.parquet").read_bytes() == expected
    shown = {key: grown[key] for key in grown if key not in {"wall_s", "computed", "table"}}
    assert shown == {key: alone[key] for key in shown}
    rows = table("alone")
    assert [row["run"] for row in rows] == [*range(6)]
    assert len({row["drawn.capacity.air"] for row in rows}) == 6
    (worst,) = [each for each in alone["worst"] if each["what"] == "hottest air"]
    assert worst["run"] == max(rows, key=lambda row: row["peak.air_c"])["run"]
    words = shlex.split(worst["command"])
    assert words[0] == "heatwright"
    again = heatwright(shlex.join([*words[1:], "--json", "--plot", "run.html"])).json
    assert again["row"] == rows[worst["run"]]
    assert f"run {worst['run']} of seed 0" in Path("run.html").read_text("utf-8")


def test_runs_of_another_campaign_are_not_mixed(heatwright: Heatwright) -> None:
    line = short_chamber("20 s").replace(" --vary vary.yaml", "") + " --processes 1 -o kept"
    heatwright(f"{line} --runs 1")
    before = Path("kept/runs.jsonl").read_bytes()
    Path("few.yaml").write_text("ambient: ± 5 K\n", encoding="utf-8")
    told = heatwright(f"{line} --runs 2 --seed 1 --vary few.yaml", status=2).err
    assert told.splitlines()[-1] == (
        "kept: has runs of another vary and another seed, which must not be mixed with new runs. "
        "Name another folder with --output, or delete this one."
    )
    longer = Path("short.yaml").read_text("utf-8").replace("ambient: 20 °C", "ambient: 21 °C")
    Path("short.yaml").write_text(longer, encoding="utf-8")
    told = heatwright(f"{line} --runs 2", status=2).err
    assert "kept: has runs of another spec" in told
    Path("other").mkdir()
    Path("other/mine.txt").write_text("mine", encoding="utf-8")
    told = heatwright(f"{line.replace('kept', 'other')} --runs 1", status=2).err
    assert "other: has other files and no campaign. Name another folder" in told
    assert Path("kept/runs.jsonl").read_bytes() == before


def test_what_does_not_go_together_and_what_is_missing(
    heatwright: Heatwright, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = heatwright("campaign chamber.yaml --plot x.png", status=2).err
    assert told == "--plot draws a single run: give --only, too.\n"
    told = heatwright("campaign chamber.yaml --only 1 --report x.html", status=2).err
    assert told == "--only can be combined with --vary, --seed, --plot and --json only.\n"
    with monkeypatch.context() as bare:
        bare.setattr("heatwright.cli.commands.campaign.find_spec", lambda _: None)
        told = heatwright("campaign chamber.yaml", status=3).err
        assert told == "A campaign needs pyarrow: pip install 'heatwright[campaign]'\n"
        told = heatwright("campaign chamber.yaml --scheduler tcp://x:1", status=3).err
        assert told.startswith("A campaign needs pyarrow and distributed: pip install ")
    told = heatwright(f"{short_chamber()} --scheduler nowhere", status=2).err
    assert "nowhere: no Dask scheduler answers there (missing port number in " in told


def test_a_worker_with_another_version_is_refused(task: Callable[..., Task]) -> None:
    other = replace(task({}, {"for": "1 s"}), heatwright="0.0.1").pack()
    with pytest.raises(Refused, match=r"has heatwright 0\.\d.*, and this computer 0\.0\.1: "):
        run_whole(other, 0)


def children(pid: int) -> list[int]:
    """The workers of a command; multiprocessing has a process of its own beside them."""
    found = finished(["ps", "-ww", "-o", "pid=,args=", "--ppid", str(pid)]).stdout
    return [int(line.split()[0]) for line in found.splitlines() if "resource_tracker" not in line]


def test_after_ctrl_c_and_a_killed_worker_nothing_is_lost_or_done_twice(
    heatwright: Heatwright,
) -> None:
    line = f"{short_chamber('10 min')} --runs 14 -o kept"
    words = [*PROGRAM, *shlex.split(line), "--processes", "2"]
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as process:
        wait_for(lambda: kept("kept") >= 1, "nothing is done", process)
        os.kill(children(process.pid)[0], signal.SIGKILL)
        wait_for(lambda: kept("kept") >= 4, "it does not go on after a worker was killed", process)
        process.send_signal(signal.SIGINT)
        assert process.stderr is not None
        told = process.stderr.read()
    assert process.returncode == 130, told
    assert "Traceback" not in told
    before = kept("kept")
    assert before < 14
    assert heatwright(f"{line} --json").json["computed"] == 14 - before
    lines = Path("kept/runs.jsonl").read_text("utf-8").splitlines()
    assert sorted(json.loads(line)["run"] for line in lines) == [*range(14)]


def test_processes_that_are_killed_again_and_again_end_it(
    task: Callable[..., Task], monkeypatch: pytest.MonkeyPatch
) -> None:
    def die(*_: object) -> None:
        os.kill(os.getpid(), signal.SIGKILL)

    monkeypatch.setattr("heatwright.cli.campaign.work.run_one", die)
    with pytest.raises(Refused, match=r"if memory is short, try fewer --processes"):
        run_here(task({}, {"for": "1 s"}).pack(), [0, 1], 2, Mock(), Mock())


def test_as_many_processes_as_there_are_cores_that_may_be_used() -> None:
    assert processes() == len(os.sched_getaffinity(0))
    code = "import os; os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})\n"
    code += "from heatwright.cli.pool import processes; print(processes())"
    assert finished([sys.executable, "-c", code]).stdout == "1\n"


@pytest.fixture(scope="module")
def task(chamber: Controller, chamber_elf: Path) -> Callable[..., Task]:
    def made(vary: Vary | dict[str, Any], *events: dict[str, Any]) -> Task:
        controller = with_scenario(chamber, *events)
        vary = vary if isinstance(vary, Vary) else vary_of(vary)
        return Task(controller, vary, 0, chamber_elf.read_bytes())

    return made


def test_a_machine_that_does_not_vary_is_the_one_that_is_simulated(heatwright: Heatwright) -> None:
    """The steps of time of both differ: readings by a step of the sensor at most."""
    short_chamber("8 min")
    Path("same.yaml").write_text("ambient: 20 °C\n", encoding="utf-8")
    row = heatwright("campaign short.yaml --vary same.yaml --only 0 --json").json["row"]
    found = heatwright("simulate short.yaml --json").json["loops"]["air"]["closed_loop"]
    step_k = example("chamber").controller.thermometers["air"].step_k
    assert row["outcome"] == "well"
    assert abs(row["loop.air.maximum_c"] - found["maximum"]) <= step_k
    assert abs(row["loop.air.overshoot_k"] - found["overshoot"]) <= step_k
    assert abs(row["loop.air.switchings"] - found["switchings"]) <= 1


def test_c_steps_the_drawn_plant_as_python_does(
    task: Callable[..., Task], chamber_elf: Path
) -> None:
    """With an error and noise at its sensor, another supply, and a jump of a node."""
    given_ = {"capacities": {"all": "± 20 %"}, "errors": {"air": "0.4 K"},
              "noise": {"air": "0.1 K"}, "supply": "90 %"}  # fmt: skip
    made = task(given_, {"at": "5 s", "press": "up", "times": 3}, {"for": "60 s"})
    drawn = draw(made.controller, made.vary, 0, 1)
    world = DrawnWorld(drawn, Elf(chamber_elf))
    world.play(lambda *_: None)
    machine, rows = world._machine, world._machine.rows
    plant = plant_of(
        drawn.powered, drawn.controller.simulated.plant,
        ambient_c=drawn.controller.simulated.ambient_c, step_s=world.step_s,
        seed=drawn.noise_seed, errors=drawn.errors,
    )  # fmt: skip
    felt = []
    for row, given_shares in zip(rows, machine.given(rows), strict=True):
        felt.append(plant.sensed_c()["air"])
        plant.step(dict(zip(machine.loads, given_shares.tolist(), strict=True)), row[FEED])
    assert np.abs(rows[:, TIPS] - felt).max() < 1e-9
    assert np.ptp(felt) > 1.0, "it was heated"
    assert abs(felt[0] - 20.4) < 1.0
    quiet = draw(made.controller, vary_of({}), 0, 1)
    still = DrawnWorld(quiet, Elf(chamber_elf))
    assert still._machine.rows[0, TIPS] == 20.0


def test_upsets_and_operators_act(task: Callable[..., Task]) -> None:
    made = task(
        {"asks": [{"loop": "air", "at": "5 s", "setpoint": "40 °C"}],
         "upsets": [{"at": "20 s", "node": "air", "by": "-4 K"},
                    {"at": "30 s", "power_cut": "3 s"}]},
        {"for": "40 s"},
    )  # fmt: skip
    done = run_whole(made.pack(), 0, logs_nodes=True)
    log = done.trace.steps["air"]
    assert log["setpoint_c"][25] == 40.0
    assert log["setpoint_c"][-1] == 20.0, "it has forgotten that without power"
    air_c, times_s = done.trace.temperatures_c["air"], done.trace.times_s
    at = int(np.searchsorted(times_s, 20.05))
    assert air_c[at + 1] - air_c[at - 1] == pytest.approx(-4.0, abs=0.3)
    off = np.count_nonzero(np.diff(times_s) == 0)
    assert off == pytest.approx(30, abs=2), "3 s without power, a tenth of a second each"
    told = [event.text for event in done.trace.events]
    assert told == ["air 40 °C", "air -4.0 K", "power cut 3 s"]
    assert done.row["outcome"] == "well"


SOON_S = {"sensor_cut": 6.0}
"""Within this long the chamber catches these: by `stale_after`, and a step."""


@pytest.mark.parametrize("name", [each for each in BREAKS if each != "fan_stalled"])
def test_what_breaks_is_caught(name: str, task: Callable[..., Task]) -> None:
    """While it heats: each is noticed within what its rules take, and the run ends soon after."""
    faults = {"chance": "100 %", "of": [name], "at": "60 s"}
    pressed = {"at": "2 s", "press": "up", "times": 3}
    made = task({"faults": faults}, pressed, {"for": "12 min"})
    row = run_whole(made.pack(), 0).row
    assert (row["drawn.fault"], row["drawn.fault.loop"]) == (name, "air")
    assert row["loop.air.overshoot_k"] is None
    if name == "switch_leaking":  # holds less than the loop itself: nothing is wrong yet
        assert row["outcome"] == "unnoticed"
        return
    assert row["outcome"] == "caught", row
    after_s = row["tripped_after_s"]
    assert isinstance(after_s, float)
    assert 0 < after_s <= SOON_S.get(name, 660.0)


def test_a_trip_with_nothing_broken_is_told(task: Callable[..., Task]) -> None:
    """The loop's maximum is 85 °C: a jump beyond it trips."""
    upset = {"at": "5 s", "node": "air", "by": "90 K"}
    row = run_whole(task({"upsets": [upset]}, {"for": "60 s"}).pack(), 0).row
    assert row["outcome"] == "tripped"
    assert row["rule"] in {"over_temperature", "rise_rate"}
    assert row["tripped_after_s"] is None


@pytest.mark.parametrize("name", EXAMPLE_NAMES)
def test_every_example_and_each_fault_of_it(
    name: str, heatwright: Heatwright, tmp_path: Path
) -> None:
    """Half a minute of its scenario, with a fault in every run."""
    text = (EXAMPLES / f"{name}.yaml").read_text("utf-8")
    short, count = re.subn(r"\{for: [^}]*\}", "{for: 30 s}", text, count=1)
    assert count == 1
    scenario = short.partition("  scenario:")
    kept_ = [line for line in scenario[2].splitlines(keepends=True)
             if not (found := re.search(r"at: (\d+) (s|min|h)\b", line))
             or (found[2] == "s" and int(found[1]) < 25)]  # fmt: skip
    Path("short.yaml").write_text(scenario[0] + scenario[1] + "".join(kept_), encoding="utf-8")
    Path("vary.yaml").write_text(
        "capacities: {all: ± 20 %}\nresistances: {all: ± 20 %}\nsupply: ± 5 %\n"
        "faults: {chance: 75 %, at: 10 s}\n", encoding="utf-8",
    )  # fmt: skip
    told = heatwright("campaign short.yaml --vary vary.yaml --runs 12 --report r.html --json").json
    assert told["outcomes"]["tripped"] == 0
    rows = table("short.campaign")
    broken = [row for row in rows if row["drawn.fault"] is not None]
    assert len({(row["drawn.fault"], row["drawn.fault.loop"]) for row in broken}) >= 3
    loops = example(name).controller.loops
    for row in rows:
        assert all(row[f"loop.{loop}.maximum_c"] is not None for loop in loops) or row in broken
    page = Path("r.html").read_text("utf-8")
    assert "--only " in page
    figures = re.findall(r'<figure class="chart">.*?>(.*?)</script>', page, re.DOTALL)
    shown = [json.loads(figure)["panels"][0]["series"][0] for figure in figures]
    counts = [sum(each["v"]) for each in shown if each["name"].endswith(", all runs")]
    nodes = [each for each in rows[0] if each.startswith("peak.")]
    assert counts == [len(rows)] * len(nodes)


def test_an_outcome_of_the_vary_of_any_machine(chamber: Controller, chamber_elf: Path) -> None:
    """What is derived runs as it is, and its row has all columns whatever happens."""
    controller = with_scenario(chamber, {"at": "5 s", "press": "up"}, {"for": "20 s"})
    vary = given(example("chamber"), None)
    columns = set()
    for run in range(8):
        drawn = draw(controller, vary, 0, run)
        world = DrawnWorld(drawn, Elf(chamber_elf))
        world.play(lambda *_: None)
        columns.add(tuple(outcome(world, drawn, controller).row))
    assert len(columns) == 1


BIN = Path(sys.executable).parent


class Cluster:
    def __init__(self, folder: Path) -> None:
        self._log = folder / "dask.log"
        self.running: list[subprocess.Popen[bytes]] = []
        file = folder / "scheduler.json"
        self.scheduler = self._start("scheduler", "--port", "0", "--scheduler-file", str(file))
        wait_for(
            lambda: file.is_file() and file.read_bytes().rstrip().endswith(b"}"),
            "no scheduler", self.scheduler,
        )  # fmt: skip
        self.address = str(json.loads(file.read_text("utf-8"))["address"])

    def worker(self, threads: int) -> subprocess.Popen[bytes]:
        return self._start("worker", self.address, "--nthreads", str(threads), "--no-nanny")

    def _start(self, *words: str) -> subprocess.Popen[bytes]:
        command = [str(BIN / "dask"), *words, "--no-dashboard", "--host", "127.0.0.1"]
        with self._log.open("ab") as log:
            self.running.append(subprocess.Popen(command, stdout=log, stderr=log))
        return self.running[-1]


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    made = Cluster(tmp_path)
    yield made
    for process in made.running:
        process.kill()
        process.wait()


def begun(line: str, cluster: Cluster) -> subprocess.Popen[str]:
    """Start a campaign on the cluster, with rows in `there`, and wait for the first of them."""
    words = shlex.split(f"{line} --scheduler {cluster.address} -o there")
    process = subprocess.Popen([*PROGRAM, *words], stderr=subprocess.PIPE, text=True)
    wait_for(lambda: kept("there") >= 2, "nothing is done", process)
    return process


def test_the_same_bytes_although_a_worker_is_killed(
    heatwright: Heatwright, cluster: Cluster
) -> None:
    """Two workers, the second with two threads; the first is killed in the middle."""
    line = f"{short_chamber('10 min')} --runs 30"
    first = cluster.worker(1)
    with begun(line, cluster) as process:
        cluster.worker(2)
        with Client(cluster.address) as client:
            client.wait_for_workers(2, timeout=60)
        assert kept("there") < 30, "the second worker has come too late"
        first.kill()
        told = process.communicate()[1]
    assert process.returncode == 0, told
    assert "Traceback" not in told
    lines = Path("there/runs.jsonl").read_text("utf-8").splitlines()
    assert sorted(json.loads(each)["run"] for each in lines) == [*range(30)]
    heatwright(f"{line} -o here")
    assert Path("here/runs.parquet").read_bytes() == Path("there/runs.parquet").read_bytes()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_what_is_done_is_kept_where_the_command_or_the_scheduler_ends(
    heatwright: Heatwright, cluster: Cluster, number: signal.Signals
) -> None:
    line = f"{short_chamber('1 min')} --runs 300"
    cluster.worker(1)
    with begun(line, cluster) as process:
        (process if number is signal.SIGINT else cluster.scheduler).send_signal(number)
        told = process.communicate()[1]
    assert "Traceback" not in told
    assert (process.returncode, told.splitlines()[-1]) == (
        (130, "Interrupted.") if number is signal.SIGINT else
        (2, f"{cluster.address}: the connection is lost. {GOES_ON}")
    )  # fmt: skip
    there = kept("there")
    assert 2 <= there < 300
    told = heatwright(f"{line.replace('300', str(there + 1))} -o there --json").json
    assert told["computed"] == 1
