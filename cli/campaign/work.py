"""The work of one worker, here or on a cluster: runs, one after the other, with one firmware."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from hashlib import sha256
from importlib.metadata import version
from typing import TYPE_CHECKING

from heatwright.cli.ends import Refused
from heatwright.cli.pool import WorkerDied, processes, spread
from heatwright.cli.talk import Counter, Job
from heatwright.cli.targets import whole
from heatwright.sim.binary.elf import Elf
from heatwright.sim.campaign.drawn import draw
from heatwright.sim.campaign.outcome import Outcome, Row, outcome
from heatwright.sim.campaign.vary import Vary
from heatwright.sim.campaign.world import DrawnWorld, Progress
from heatwright.spec import Controller
from heatwright.spec.loading.user_cache import cache_dir

if TYPE_CHECKING:
    from collections.abc import Sequence

Came = Callable[[Row], None]

GOES_ON = "All finished runs are kept: the same command continues."
MOST_DEATHS = 3
"""How many times the processes are restarted after one of them was killed."""


@dataclass(frozen=True)
class Task:
    """Everything that a run depends on, except its number."""

    controller: Controller
    vary: Vary
    seed: int
    elf: bytes
    """The binary, with its debug information."""
    heatwright: str = field(default_factory=lambda: version("heatwright"))

    def pack(self) -> bytes:
        """Serialize the task for a worker."""
        return pickle.dumps(self, protocol=5)


def _nothing(done: float, total: float) -> None:
    del done, total


@lru_cache(maxsize=2)
def _unpacked(packed: bytes) -> tuple[Task, Elf]:
    """Load task and firmware once in each process."""
    task: Task = pickle.loads(packed)  # noqa: S301 - the bytes are from Task.pack
    if task.heatwright != (here := version("heatwright")):
        raise Refused(
            f"A worker has heatwright {here}, and this computer {task.heatwright}: their runs "
            "must not be mixed. Install the same version on both."
        )
    return task, program_of(task.elf)


def program_of(elf: bytes) -> Elf:
    """Put a binary into the user's cache, where the simulator reads its debug information."""
    file = cache_dir() / "campaigns" / f"{sha256(elf).hexdigest()[:16]}.elf"
    if not file.is_file():
        file.parent.mkdir(parents=True, exist_ok=True)
        with whole(file) as fresh:
            fresh.write_bytes(elf)
    return Elf(file)


def run_whole(
    packed: bytes, number: int, progress: Progress = _nothing, *, logs_nodes: bool = False
) -> Outcome:
    """Do one run, and return all its results."""
    task, program = _unpacked(packed)
    drawn = draw(task.controller, task.vary, task.seed, number)
    world = DrawnWorld(drawn, program, logs_nodes=logs_nodes)
    world.play(progress)
    return outcome(world, drawn, task.controller)


def run_one(packed: bytes, number: int) -> Row:
    """Do one run, and return its row."""
    return run_whole(packed, number).row


# -- on this machine -----------------------------------------------------------------------------


_packed = b""
"""The packed task of the workers on this computer: they get it when they are forked."""


def _do(number: int, job: Job) -> Row:
    del job
    return run_one(_packed, number)


def run_here(
    packed: bytes, numbers: Sequence[int], count: int | None, came: Came, job: Job
) -> None:
    """Do runs in `count` processes, or one for each core; call `came` with each row as it comes."""
    global _packed  # noqa: PLW0603 - forked workers share it, without a copy for each run
    _packed = packed
    counter = Counter(job, len(numbers))
    if (count or processes()) == 1:
        for number in numbers:
            came(run_one(packed, number))
            counter.end()
        return
    _unpacked(packed)
    done: set[object] = set()

    def kept(row: Row) -> None:
        done.add(row["run"])
        came(row)

    for death in range(MOST_DEATHS + 1):
        left = [number for number in numbers if number not in done]
        try:
            spread(_do, left, [counter] * len(left), came=kept, most=count)
        except WorkerDied:
            if death == MOST_DEATHS:
                raise Refused(
                    "Worker processes were killed repeatedly; if memory is short, try fewer "
                    f"--processes. {GOES_ON}"
                ) from None
        else:
            return
