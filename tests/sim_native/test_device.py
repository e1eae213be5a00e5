"""The device runs any part that says when it acts, also one of a kind that it does not know."""

import numpy as np
import pytest
from rig.firmware import device_of

from heatwright.sim.avr import Avr
from heatwright.sim.interfaces import serial_plotter

EVERY_S = 0.25


class Beacon:
    """A part that acts four times a second, and is in an exchange in the first second."""

    complaints = ()

    def __init__(self, avr: Avr) -> None:
        self._avr = avr
        self._next = round(EVERY_S * avr.clock_hz)
        self.acted_s: list[float] = []
        self.records = 0

    def feed(self, pins: np.ndarray, sent: np.ndarray) -> None:
        self.records += len(sent) + len(pins)
        if self._avr.cycle >= self._next:
            self.acted_s.append(self._avr.time_s)
            self._next += round(EVERY_S * self._avr.clock_hz)

    @property
    def wake_cycle(self) -> int | None:
        return self._next

    @property
    def is_busy(self) -> bool:
        return self._avr.time_s < 1.0


def test_a_part_of_any_kind_acts_when_it_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(serial_plotter, "attach", lambda avr, *_: Beacon(avr))
    device = device_of("chamber", 25.0)
    (beacon,) = device.parts(Beacon)
    device.advance(0.9)
    assert device.is_attended
    device.advance(2.1)
    assert not device.is_attended
    assert beacon.acted_s == pytest.approx([EVERY_S * each for each in range(1, 9)], abs=1e-3)
    assert beacon.records > 0


def test_a_step_is_logged_as_it_is_at_the_end_of_its_tick() -> None:
    """A master's answer, before the processor sleeps, belongs to the next step."""
    device = device_of("chamber", 25.0)
    avr, steps = device.avr, device.variables["loop_air.steps"]
    ends = device.elf.function("clock_wait")
    device.advance(3.5)
    while device.read("loop_air.steps") < 5:
        assert avr.run_to_code(ends, device.cycle_at(10.0))
    avr.run_to(avr.cycle + 1)
    avr.write_ram(steps.address, bytes([0]))
    device.advance(4.9)
    assert device.steps("air")["steps"].tolist()[-2:] == [4, 5]
