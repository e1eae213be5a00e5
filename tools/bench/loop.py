# SPDX-License-Identifier: GPL-3.0-or-later
"""Run the closed loop of a spec by its binary; print what it took as JSON.

    python tools/bench/loop.py SPEC

Run by the Python of another checkout, it measures that one: it uses what all of them have.
"""

import json
import sys
import time

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
    start = time.process_time()
    trace = bench(controller, device)
    took_s = time.process_time() - start
    speed = trace.duration_s / took_s
    found = {
        "simulated_s": trace.duration_s,
        "speed": speed,
        "limit": limit(device, controller.board.mcu),
    }
    print(json.dumps(found))


def limit(device: AvrDevice, mcu: str) -> float | None:
    """Return the limit of the speed; None in a checkout that does not know it yet."""
    try:
        from heatwright.sim.limit import limit_of  # noqa: PLC0415
    except ImportError:
        return None
    return limit_of(device.avr, mcu, device.elf).speed


if __name__ == "__main__":
    main()
