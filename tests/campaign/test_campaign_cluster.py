"""A campaign on a real Dask scheduler and its workers, on this computer."""

import json
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from campaign.campaigns import kept, short_chamber, wait_for
from distributed import Client
from rig.commands import Heatwright

from heatwright.cli.campaign.work import GOES_ON

BIN = Path(sys.executable).parent


class Cluster:
    """A scheduler and its workers; all of them end with the test."""

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
    process = subprocess.Popen(
        [sys.executable, "-m", "heatwright.cli.start", *words], stderr=subprocess.PIPE, text=True
    )
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
