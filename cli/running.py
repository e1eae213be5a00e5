"""Runs a spec on its simulated machine, with the binary or with the reference model."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

from heatwright.cli.ends import Refused
from heatwright.cli.talk import Progress
from heatwright.sim.bench import Device, ReferenceDevice, bench
from heatwright.sim.judges.metrics import Metrics, metrics
from heatwright.sim.plants import plant_module
from heatwright.sim.plots.plot_data import Tripped, faults
from heatwright.sim.trace import Trace
from heatwright.spec import Controller
from heatwright.spec.board.uses import PinUse, pin_uses

if TYPE_CHECKING:
    from heatwright.sim.binary.elf import Elf
    from heatwright.sim.device import AvrDevice
    from heatwright.sim.judges.limit import Limit
    from heatwright.sim.plots.vcd import VcdRecorder


@dataclass(frozen=True)
class Run:
    """The results of a run."""

    trace: Trace
    wall_s: float
    """Real time it took, s."""
    figures: dict[str, Metrics]
    """Figures of merit, by loop."""
    faults: dict[str, tuple[Tripped, ...]]
    """Faults with their times, by loop."""
    display: tuple[str, ...] | None = None
    """Text of the display at the end; None without a display, or without a binary."""
    screen: bytes | None = None
    """Page of the touch display at the end, as a PNG."""
    lights: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    """States of each loop's LEDs at the end, by the LED's meaning."""
    not_done: tuple[tuple[float, str], ...] | None = None
    """Requests of host or master that were not done: time, s, and the answer; None with the
    model, which has no interfaces."""
    complaints: tuple[str, ...] = ()
    """Violations reported by the chips at the binary's pins and by the processor."""
    limit: Limit | None = None
    """Highest possible speed, set by the processor alone; None without a binary."""

    @property
    def speed(self) -> float:
        """How many times faster than the real machine."""
        return self.trace.duration_s / self.wall_s


def run_model(controller: Controller, progress: Progress) -> Run:
    """Run the reference model: the control equations with ideal timing."""
    return _run(controller, ReferenceDevice(controller), progress)


def run_binary(
    controller: Controller, elf: Path | Elf, progress: Progress, vcd: Path | None = None
) -> Run:
    """Run the binary in the simulated processor; `vcd`: write the activity of its pins there."""
    from heatwright.cli.chips import complaints, display, lights, not_done, screen  # noqa: PLC0415
    from heatwright.sim.device import AvrDevice  # noqa: PLC0415 - needs the native part
    from heatwright.sim.judges.limit import limit_of  # noqa: PLC0415

    device = AvrDevice(controller, elf)
    with ExitStack() as stack:
        if vcd is not None:
            stack.enter_context(_recorded(controller, device, vcd))
        run = _run(controller, device, progress)
        device.feed()
    return replace(
        run,
        display=display(device),
        screen=screen(device),
        lights=lights(controller, device),
        not_done=not_done(device),
        complaints=complaints(device),
        limit=limit_of(device.avr, controller.board.mcu, device.elf),
    )


def _recorded(controller: Controller, device: AvrDevice, vcd: Path) -> VcdRecorder:
    from heatwright.sim.plots.vcd import VcdRecorder  # noqa: PLC0415

    pins = watched_pins(controller)
    for pin in pins.values():
        device.avr.pins.watch(pin)
    recorder = VcdRecorder(vcd, pins, controller.board.clock_hz)
    device.record(recorder)
    return recorder


def watched_pins(controller: Controller) -> dict[str, str]:
    """Name the pins that the spec uses, for a VCD viewer: name and purpose, without blanks."""
    return {
        f"{use.pin.name}_{_purpose(use)}": use.pin.port_name
        for use in pin_uses(controller)
        if use.pin.digital
    }


def _purpose(use: PinUse) -> str:
    """Name a pin's purpose, in the letters that a VCD viewer accepts."""
    words = use.purpose.removeprefix("the ") or str(use.path[1])
    return "_".join(words.replace("'s", "").split())


def _run(controller: Controller, device: Device, progress: Progress) -> Run:
    if controller.simulation is not None:
        plant_module(controller.simulation.plant.kind)  # the measured time excludes this import
    start = perf_counter()
    trace = bench(controller, device, progress=progress)
    wall_s = perf_counter() - start
    return Run(
        trace=trace,
        wall_s=wall_s,
        figures=_figures(trace, controller),
        faults={loop: faults(log) for loop, log in trace.steps.items()},
    )


def _figures(trace: Trace, controller: Controller) -> dict[str, Metrics]:
    try:
        return {loop: metrics(trace, controller, loop) for loop in controller.loops}
    except ValueError as error:  # the run has no reading
        raise Refused(f"{error}: simulate a longer time, or check the sensor.") from None
