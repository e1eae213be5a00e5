"""Random and damaged frames against the binary: no wrong answer, write, tick or reset."""

from collections.abc import Iterator

import numpy as np
import pytest
from hostile_frames import Hostile, Hostility
from modbus_wire import CALM, Wire, powered
from rig.modbus_oracle import Oracle
from suite import amount

from heatwright.sim.device import AvrDevice
from heatwright.sim.interfaces.modbus_frames import crc
from heatwright.spec import Controller

RUNS = {
    ("fabricator", 115_200): 0.45,
    ("fabricator", 19_200): 0.07,
    ("dryer", 115_200): 0.45,
    ("dryer", 1_200): 0.03,
}
"""Shares of all frames; most of them as fast as they come."""
LEAST = 300
ROOM_C = 50.0
VOLATILE = {2: range(3), 4: range(3), 17: (0, 1, 2, 3, *range(5, 40))}
"""Functions whose answers tell what only the machine knows: what of them is compared."""


def expected(oracle: Oracle, hostile: Hostile) -> bytes:
    """The answer to what arrives; of a torn frame to either part."""
    answers = [oracle.hear(part, whole=hostile.whole) for part in hostile.parts]
    return next(filter(None, answers), b"")


def compare(got: bytes, wanted: bytes) -> bool:
    if not got or not wanted or wanted[1] not in VOLATILE:
        return got == wanted
    right = len(got) == len(wanted) and crc(got[:-2]) == got[-2:]
    return right and all(got[n] == wanted[n] for n in VOLATILE[wanted[1]] if n < len(wanted) - 2)


def settings(device: AvrDevice, loop: str, oracle: Oracle) -> Iterator[tuple[str, float, float]]:
    """What the binary holds, and what it should."""
    control = oracle.loops[loop]
    yield "setpoint", float(device.read(f"settings.{loop}_setpoint_c")), control.setpoint
    for gain, wanted in control.gains.items():
        yield gain, float(device.read(f"settings.{loop}_{gain}")), wanted


@pytest.mark.parametrize(("name", "baud"), RUNS)
def test_whatever_arrives(name: str, baud: int) -> None:
    frames = max(LEAST, round(amount("modbus_frames_binary") * RUNS[name, baud]))
    controller, device = powered(name, baud, *CALM[name], warm_c=ROOM_C)
    device.advance(1.0)
    wire, oracle = Wire(controller, device), Oracle(controller)
    loop = next(iter(controller.loops))
    hostility = Hostility(oracle.address, wire.bus, baud)
    answered = 0
    for number, hostile in enumerate(hostility.frames(frames)):
        wanted = expected(oracle, hostile)
        frame = wire.ask(hostile.sent)
        got = b"" if frame is None else frame.data
        assert compare(got, wanted), f"{number}: {hostile}: {got!r}, not {wanted!r}"
        answered += got != b""
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
