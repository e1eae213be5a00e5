"""A campaign's runs on the workers of a Dask scheduler."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from typing import Any

from distributed import Client, as_completed
from distributed.scheduler import KilledWorker

from heatwright.cli.campaign.work import GOES_ON, Came, run_one
from heatwright.cli.ends import Refused
from heatwright.cli.talk import Counter, Job

CONNECT_S = 10


def run_there(packed: bytes, numbers: Sequence[int], scheduler: str, came: Came, job: Job) -> None:
    """Do runs on the workers of a scheduler; each row as it comes.

    The scheduler gives a run whose worker dies to another one, some times.
    """
    counter = Counter(job, len(numbers))
    with _client(scheduler) as client:
        job.note(f"{len(client.nthreads())} workers")
        for row in _rows(client, packed, numbers, scheduler):
            came(row)
            counter.end()


def _rows(client: Any, packed: bytes, numbers: Sequence[int], scheduler: str) -> Iterator[Any]:
    """Yield each row as it comes; an error of the line to the scheduler is none of a file."""
    try:
        # The result of a task, and no scattered data: it is made again where its worker dies.
        task = client.submit(bytes, packed, pure=False)
        for future in as_completed(client.map(run_one, [task] * len(numbers), numbers, pure=False)):
            yield _row(future, scheduler)
            future.release()  # else its worker's death would have it done once more
    except OSError as error:
        raise Refused(f"{scheduler}: the scheduler has gone. {GOES_ON}") from error


def _row(future: Any, scheduler: str) -> Any:
    try:
        return future.result()
    except KilledWorker:
        told = "a run has ended one worker after the other; see what they say"
    except CancelledError:
        told = "the scheduler has gone"
    except ImportError as error:
        told = f"a worker has not what this computer has ({error}); install heatwright there"
    raise Refused(f"{scheduler}: {told}. {GOES_ON}")


@contextmanager
def _client(scheduler: str) -> Iterator[Any]:
    try:
        client = Client(scheduler, timeout=CONNECT_S)
    except (OSError, ValueError, TypeError) as error:
        told = str(error).splitlines()
        raise Refused(
            f"{scheduler}: no Dask scheduler answers there ({told[0] if told else 'no answer'}). "
            "Start one with dask scheduler, and workers with dask worker ADDRESS."
        ) from None
    logging.disable()  # what matters is told here
    try:
        with client:
            yield client
    finally:
        logging.disable(logging.NOTSET)
