# SPDX-License-Identifier: GPL-3.0-or-later
"""Run the closed loop of a spec by its binary; print what it took as JSON.

    python tools/bench/loop.py SPEC

Run by the Python of another checkout, it measures that one: it uses what all of them have, and
leaves out where the time goes.
"""

import json
import sys
import time
from types import SimpleNamespace
from typing import Any

from heatwright.cli.firmware import build_firmware
from heatwright.sim.bench import bench
from heatwright.sim.device import AvrDevice
from heatwright.sim.plants import plant_module
from heatwright.spec import load


class Silent:
    """A job that nobody looks at."""

    def __call__(self, done: float, total: float) -> None:
        """Hear how far it is."""

    def note(self, text: str) -> None:
        """Hear what it does."""

    def end(self, text: str = "") -> None:
        """Hear that it is done."""


def main() -> None:
    """Build, run, print."""
    spec = load(sys.argv[1])
    controller = spec.controller
    elf = build_firmware(spec, Silent()).elf
    if controller.simulation is not None:
        plant_module(controller.simulation.plant.kind)  # the import is no part of the run
    device = AvrDevice(controller, elf)
    in_c = InC()
    start = time.process_time()
    trace = bench(controller, device)
    took_s = time.process_time() - start
    found = {
        "simulated_s": trace.duration_s,
        "speed": trace.duration_s / took_s,
        "limit": limit(device, controller.board.mcu),
        "in_c": in_c.took_s / took_s,
    }
    print(json.dumps(found))


class InC:
    """Measures the processor time spent in C: processor, chips and plant until Python is needed."""

    def __init__(self) -> None:
        """Listen from now on; in a checkout whose plant is in Python there is nothing to hear."""
        self.took_s = 0.0
        try:
            from heatwright.sim import machine  # noqa: PLC0415
        except ImportError:
            return
        native = machine.load()
        machine.load = lambda: SimpleNamespace(lib=self, ffi=native.ffi)
        self._lib = native.lib

    def __getattr__(self, name: str) -> Any:
        """Return what the library has."""
        return getattr(self._lib, name)

    def hw_machine_go(self, *given: Any) -> int:
        """Go on, and count how long it takes."""
        start_s = time.process_time()
        ended: int = self._lib.hw_machine_go(*given)
        self.took_s += time.process_time() - start_s
        return ended


def limit(device: AvrDevice, mcu: str) -> float | None:
    """Return the limit of the speed; None in a checkout that does not know it yet."""
    try:
        from heatwright.sim.judges.limit import limit_of  # noqa: PLC0415
    except ImportError:
        return None
    return limit_of(device.avr, mcu, device.elf).speed


if __name__ == "__main__":
    main()
