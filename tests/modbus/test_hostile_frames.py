"""100 000 random and damaged frames against the binary: no wrong answer, write, tick or reset."""

import struct
from collections.abc import Iterator

import numpy as np
import pytest
from hostile_frames import Hostile, Hostility
from modbus_build import Build
from modbus_oracle import Oracle
from modbus_wire import Wire

from heatwright.sim.device import AvrDevice
from heatwright.sim.interfaces.modbus_frames import crc
from heatwright.spec import Controller

RUNS = [
    ("fabricator", 115_200, 45_000),
    ("fabricator", 19_200, 7_000),
    ("dryer", 115_200, 45_000),
    ("dryer", 1_200, 3_000),
]
"""100 000 frames, most of them as fast as they come."""
ROOM_C = 50.0
CALM = {
    "fabricator": (
        ("baud: 19200", "baud: BAUD"),
        ("{rise: 5 K, within: 30 s}", "off"),
        ("{above: 20 K, for: 60 s}", "off\n      frozen: off\n      rising_while_off: off"),
        (", current: {sensor: current, limit: 3 A}", ""),
        ("  current: {kind: current, pin: PA1, scale: 0.2 V/A, oversample: 4}\n", ""),
        (", current: {of: heater}", ""),
    ),
    "dryer": (
        ("baud: 38400", "baud: BAUD"),
        ("{rise: 2 K, within: 2 min}", "off"),
        ("{above: 8 K, for: 1 min}", "off\n      frozen: off\n      rising_while_off: off"),
    ),
}
"""Rules that judge the machine are off: nobody simulates it here, its temperature stands still."""
VOLATILE = {2: range(3), 4: range(3), 17: (0, 1, 2, 3, *range(5, 40))}
"""Functions whose answers tell what only the machine knows: what of them is compared."""


def expected(oracle: Oracle, hostile: Hostile) -> bytes | None:
    """The answer to what arrives; of a torn frame to either part."""
    answers = [oracle.hear(part, whole=hostile.whole) for part in hostile.parts]
    return next((answer for answer in answers if answer is not None), None)


def compare(got: bytes | None, wanted: bytes | None) -> bool:
    if got is None or wanted is None or wanted[1] not in VOLATILE:
        return got == wanted
    right = len(got) == len(wanted) and crc(got[:-2]) == got[-2:]
    return right and all(got[n] == wanted[n] for n in VOLATILE[wanted[1]] if n < len(wanted) - 2)


def settings(device: AvrDevice, loop: str, oracle: Oracle) -> Iterator[tuple[str, float, float]]:
    """What the binary holds, and what it should."""
    control = oracle.loops[loop]
    held = float(device.read(f"settings.{loop}_setpoint_c"))
    yield "setpoint", held, float(np.float32(control.setpoint) / np.float32(10))
    for gain, raw in control.gains.items():
        yield gain, float(device.read(f"settings.{loop}_{gain}")), struct.unpack(">f", raw)[0]


@pytest.mark.parametrize(("name", "baud", "frames"), RUNS)
def test_whatever_arrives(built: Build, name: str, baud: int, frames: int) -> None:
    calm = [(old, new.replace("BAUD", str(baud))) for old, new in CALM[name]]
    controller, program = built(name, *calm)
    device = AvrDevice(controller, program)
    for sensor in controller.thermometers:
        device.sense(sensor, ROOM_C)
    device.advance(1.0)
    wire, oracle = Wire(controller, device), Oracle(controller)
    loop = next(iter(controller.loops))
    hostility = Hostility(oracle.address, wire.bus, baud)
    answered = 0
    for number, hostile in enumerate(hostility.frames(frames)):
        wanted = expected(oracle, hostile)
        frame = wire.ask(hostile.sent)
        got = None if frame is None else frame.data
        assert compare(got, wanted), f"{number}: {hostile}: {got!r}, not {wanted!r}"
        answered += got is not None
        if number % 100 == 0:
            for what, held, right in settings(device, loop, oracle):
                assert held == right, f"{number}: {what}"
    assert answered > frames / 3
    assert oracle.changes > frames / 100
    assert wire.slowest_s <= 0.005
    undisturbed(controller, device)


def undisturbed(controller: Controller, device: AvrDevice) -> None:
    """Every control step was done in its tick, nothing tripped, nothing was reset."""
    assert len(device.avr.take_resets()) == 0
    assert int(device.read("fault.code")) == 0
    for name, loop in controller.loops.items():
        steps = device.steps(name)
        spacing = np.diff(steps["time_s"])
        assert abs(len(steps["time_s"]) - device.time_s / loop.period_s) <= 2
        assert np.max(np.abs(spacing - loop.period_s)) < 0.001
