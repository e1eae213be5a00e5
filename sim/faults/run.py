"""Every fault that applies to a controller, in two processes."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

from heatwright.sim.elf import Elf
from heatwright.sim.faults.catalogue import catalogue
from heatwright.sim.faults.fault import Fault, FaultResult
from heatwright.sim.faults.procedure import try_fault
from heatwright.spec import Controller, Spec

PROCESSES = 2
Progress = Callable[[float, float], None]
"""Called with the number of faults tried and their total."""

_faults: tuple[Fault, ...] = ()
"""In a worker: the catalogue."""


def run_faults(
    spec: Spec | Controller, elf: Path | str | Elf, *, progress: Progress | None = None
) -> tuple[FaultResult, ...]:
    """Try every fault on the binary.

    Args:
        spec: the specification the binary was generated from.
        elf: the binary, with debug information.
        progress: told how far it is.

    Returns:
        What was found, in the order of the catalogue.

    Raises:
        ValueError: the specification has no simulated machine.
        StaleBinary, ElfError, SimulatorMissing: as AvrDevice.

    """
    controller = spec.controller if isinstance(spec, Spec) else spec
    program = elf if isinstance(elf, Elf) else Elf(elf)
    count = len(catalogue(controller, program))
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(
        PROCESSES, context, initializer=_begin, initargs=(controller, program.path)
    ) as pool:
        waiting = [pool.submit(_try, number) for number in range(count)]
        try:
            for done, each in enumerate(as_completed(waiting), 1):
                each.result()
                if progress:
                    progress(done, count)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
        return tuple(each.result() for each in waiting)


def _begin(controller: Controller, elf: Path) -> None:
    """Set up a worker. Ctrl-C is its parent's business."""
    global _faults  # noqa: PLW0603 - the one thing a worker has of its own
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _faults = catalogue(controller, Elf(elf))


def _try(number: int) -> FaultResult:
    return try_fault(_faults[number])
