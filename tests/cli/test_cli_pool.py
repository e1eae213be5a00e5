"""Work in two processes: results in order, progress, errors."""

import os
import signal

import pytest

from heatwright.cli.ends import Refused
from heatwright.cli.pool import WorkerDied, spread
from heatwright.cli.talk import Job


class Listener:
    def __init__(self) -> None:
        self.heard: list[object] = []

    def __call__(self, done: float, total: float) -> None:
        self.heard.append((done, total))

    def note(self, text: str) -> None:
        self.heard.append(text)

    def end(self, text: str = "") -> None:
        self.heard.append(f"end{text}")


def double(piece: int, job: Job) -> int:
    job.note(f"doubling {piece}")
    job(piece, 10)
    return 2 * piece


def refuse(piece: int, _: Job) -> int:
    if piece == 2:
        raise Refused("not two")
    return piece


def die(piece: int, _: Job) -> int:
    os.kill(os.getpid(), signal.SIGKILL)
    return piece


def test_results_come_in_order_and_progress_goes_to_its_job() -> None:
    jobs = [Listener() for _ in range(3)]
    assert spread(double, [3, 1, 2], jobs) == [6, 2, 4]
    for piece, job in zip([3, 1, 2], jobs, strict=True):
        assert job.heard[-1] == "end"
        assert set(job.heard) <= {f"doubling {piece}", (piece, 10), "end"}


def test_an_error_comes_through_as_it_is() -> None:
    with pytest.raises(Refused, match="not two"):
        spread(refuse, [1, 2], [Listener(), Listener()])


def test_a_worker_that_dies_is_noticed() -> None:
    with pytest.raises(WorkerDied):
        spread(die, [1], [Listener()])
