"""What the chips around the binary have to say after a run."""

from __future__ import annotations

from collections.abc import Iterator

from heatwright.sim.avr import CAUSES
from heatwright.sim.device import AvrDevice, Sensor
from heatwright.sim.interfaces.indicators import Indicators
from heatwright.sim.interfaces.lcd_keypad import LcdKeypad
from heatwright.sim.interfaces.nextion import Nextion
from heatwright.sim.interfaces.serial_plotter import SerialPlotter
from heatwright.sim.interlock import overlaps
from heatwright.sim.sensors.ds18b20 import Ds18b20
from heatwright.sim.sensors.spi_chip import SpiChip
from heatwright.spec import Controller
from heatwright.spec import Indicators as Spec
from heatwright.spec.indicated import shown_loop


def display(device: AvrDevice) -> tuple[str, str] | None:
    """Return what the display shows; None if there is none."""
    shields = [each for each in device.interfaces if isinstance(each, LcdKeypad)]
    return shields[0].lcd.text if shields else None


def screen(device: AvrDevice) -> bytes | None:
    """Return the page of the touch display as a PNG; None if there is none."""
    displays = [each for each in device.interfaces if isinstance(each, Nextion)]
    return displays[0].picture if displays else None


def lights(controller: Controller, device: AvrDevice) -> dict[str, dict[str, str]]:
    """Return what the LEDs of each loop show, by meaning; none without LEDs."""
    return {
        shown_loop(controller, spec): dict[str, str](part.lights())
        for spec, part in zip(controller.interfaces, device.interfaces, strict=True)
        if isinstance(spec, Spec) and isinstance(part, Indicators)
    }


def complaints(device: AvrDevice) -> tuple[str, ...]:
    """Return what went against a data sheet or the interlock, and resets nobody asked for."""
    return (*_resets(device), *overlaps(device.interlocks), *_sensors(device), *_interfaces(device))


def _resets(device: AvrDevice) -> Iterator[str]:
    for reset in device.take_resets():
        time_s = int(reset["cycle"]) / device.avr.clock_hz
        yield f"{CAUSES[int(reset['cause'])]} reset at {time_s:.3f} s"


def _sensors(device: AvrDevice) -> Iterator[str]:
    for name, sensor in device.sensors.items():
        for phase, violations in _wires(sensor).items():
            if violations:
                yield f"{name}: {phase} was outside the data sheet {violations} times"


def _wires(sensor: Sensor) -> dict[str, int]:
    """Count what went against the data sheet on a sensor's wires, by phase."""
    if isinstance(sensor, Ds18b20):
        return {phase: seen.violations for phase, seen in sensor.line.phases.items()}
    if isinstance(sensor, SpiChip):
        return {phase: seen.violations for phase, seen in sensor.port.phases.items()}
    return {}


def _interfaces(device: AvrDevice) -> Iterator[str]:
    for interface in device.interfaces:
        if isinstance(interface, LcdKeypad):
            for limit, count in interface.lcd.violations.items():
                yield f"display: {limit} was below the data sheet {count} times"
        elif isinstance(interface, Nextion):
            yield from _touch_display(interface)
        elif isinstance(interface, SerialPlotter) and interface.garbage:
            yield f"serial plotter: {interface.garbage} bytes were no line of its"


def _touch_display(display: Nextion) -> Iterator[str]:
    if display.errors:
        text, code = display.errors[0]
        reason = code.name.lower().replace("_", " ")
        yield f"display: it refused {len(display.errors)} instructions, first {text!r}: {reason}"
    if display.line.garbage:
        yield f"display: {display.line.garbage} bytes had no stop bit where one belongs"
