"""The simulated chips after a run: displays, refused commands, violations of data sheets."""

from collections.abc import Iterator

from heatwright.sim.avr import CAUSES
from heatwright.sim.device import AvrDevice
from heatwright.sim.interfaces.gcode import GcodeHost
from heatwright.sim.interfaces.indicators import Indicators as Leds
from heatwright.sim.interfaces.modbus_rtu import ModbusMaster
from heatwright.sim.interfaces.nextion import Nextion
from heatwright.sim.judges.interlock import overlaps
from heatwright.spec import Controller, Indicators, placed
from heatwright.spec.commands import shown_loop


def display(device: AvrDevice) -> tuple[str, ...] | None:
    """Return the rows of the first display of text; None if there is none."""
    shown = (getattr(part, "text", None) for part in device.interfaces)
    return next((rows for rows in shown if rows is not None), None)


def screen(device: AvrDevice) -> bytes | None:
    """Return the page of the touch display as a PNG; None if there is no such display."""
    displays = device.parts(Nextion)
    return displays[0].picture if displays else None


def lights(controller: Controller, device: AvrDevice) -> dict[str, dict[str, str]]:
    """Return the states of each loop's LEDs (lit, blinking, dark), by the LED's meaning."""
    return {
        shown_loop(controller, spec): dict[str, str](leds.lights())
        for spec, leds in zip(
            placed(controller, Indicators).values(), device.parts(Leds), strict=True
        )
    }


def not_done(device: AvrDevice) -> tuple[tuple[float, str], ...]:
    """Return the failed requests of host or master: time, s, and the board's answer."""
    found = [
        *((line.time_s, line.text.removeprefix("echo:"))
          for host in device.parts(GcodeHost) for line in host.refusals),
        *((each.time_s, f"{each.name}: {_answer(each.exception)}")
          for master in device.parts(ModbusMaster) for each in master.refusals),
    ]  # fmt: skip
    return tuple(sorted(found))


def _answer(exception: int) -> str:
    return f"exception {exception}" if exception else "no answer"


def complaints(device: AvrDevice) -> tuple[str, ...]:
    """Return violations of data sheets and of the interlock, and unexpected resets."""
    return (*_resets(device), *overlaps(device.interlocks), *_sensors(device), *_interfaces(device))


def _resets(device: AvrDevice) -> Iterator[str]:
    for reset in device.take_resets():
        time_s = int(reset["cycle"]) / device.avr.clock_hz
        yield f"{CAUSES[int(reset['cause'])]} reset at {time_s:.3f} s"


def _sensors(device: AvrDevice) -> Iterator[str]:
    for name, sensor in device.sensors.items():
        for phase, count in sensor.violations.items():
            if count:
                yield f"{name}: {phase} was outside the data sheet {count} times"


def _interfaces(device: AvrDevice) -> Iterator[str]:
    for interface in device.interfaces:
        yield from interface.complaints
