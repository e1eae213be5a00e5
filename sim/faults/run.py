"""Every fault that applies to a controller, two at a time."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from heatwright.sim.elf import Elf
from heatwright.sim.faults.catalogue import catalogue
from heatwright.sim.faults.fault import FaultResult
from heatwright.sim.faults.procedure import try_fault
from heatwright.spec import Controller, Spec

THREADS = 2
Progress = Callable[[float, float], None]
"""Called with the number of faults tried and their total."""


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
    faults = catalogue(controller, elf if isinstance(elf, Elf) else Elf(elf))
    with ThreadPoolExecutor(THREADS) as pool:
        waiting = [pool.submit(try_fault, fault) for fault in faults]
        try:
            for done, _ in enumerate(as_completed(waiting), 1):
                if progress:
                    progress(done, len(waiting))
            return tuple(each.result() for each in waiting)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
