"""A campaign's runs on the workers of a Dask scheduler."""

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
    """Do runs on the workers of a scheduler; call `came` with each row as it comes.

    If a worker dies, the scheduler gives its run to another worker, a few times.
    """
    counter = Counter(job, len(numbers))
    with _client(scheduler) as client:
        job.note(f"{len(client.nthreads())} workers")
        for row in _rows(client, packed, numbers, scheduler):
            came(row)
            counter.end()


def _rows(client: Any, packed: bytes, numbers: Sequence[int], scheduler: str) -> Iterator[Any]:
    """Yield each row as it comes; an OSError here means that the scheduler is lost."""
    try:
        # Sent as the result of a task, not scattered: Dask makes it again if its worker dies.
        task = client.submit(bytes, packed, pure=False)
        for future in as_completed(client.map(run_one, [task] * len(numbers), numbers, pure=False)):
            yield _row(future, scheduler)
            future.release()  # else Dask would repeat this run if its worker dies
    except OSError as error:
        raise Refused(f"{scheduler}: the connection is lost. {GOES_ON}") from error


def _row(future: Any, scheduler: str) -> Any:
    try:
        return future.result()
    except KilledWorker:
        told = "one run has crashed several workers; see their messages"
    except CancelledError:
        told = "the connection is lost"
    except ImportError as error:
        told = f"a worker lacks a package ({error}); install heatwright[campaign] there"
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
    logging.disable()  # the errors that matter become messages of this module
    try:
        with client:
            yield client
    finally:
        logging.disable(logging.NOTSET)
