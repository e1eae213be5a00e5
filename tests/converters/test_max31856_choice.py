"""The operator chooses the thermocouple's type on the touch display: the kiln's binary."""

from typing import Any

import pytest
from rig.avr import whole
from rig.specs import example

from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.spec import Controller

K, S = 3, 6
"""Codes of types, which the operator may choose."""
CHOOSE_S = f"#15 {S};"
ROOM_C = 25.0


class Cold:
    """A machine of one loop at room temperature, where every type reads the same."""

    def __init__(self, controller: Controller, elf: Elf) -> None:
        self.device = AvrDevice(controller, elf)
        ((self.loop, loop),) = controller.loops.items()
        self.sensor = loop.sensor
        self.chip: Any = self.device.sensors[self.sensor]
        self.device.sense(self.sensor, ROOM_C)
        self.run(3.02)

    def run(self, seconds: float) -> None:
        self.device.advance(self.device.time_s + seconds)

    def send(self, order: str) -> None:
        self.device.send(order)
        self.run(2.0)

    @property
    def chosen(self) -> tuple[int, int]:
        """Return what the settings say, and the chip."""
        setting = int(self.device.read(f"settings.{self.sensor}_thermocouple"))
        return setting, self.chip._registers[1] & 0xF


@pytest.fixture
def cold() -> Cold:
    return Cold(example("kiln").controller, whole("kiln"))


def test_it_is_taken_over_with_the_next_reading(cold: Cold) -> None:
    assert cold.chosen == (K, K)
    done = len(cold.device.steps(cold.loop))
    cold.send(CHOOSE_S)
    assert cold.chosen == (S, S)
    cold.run(1.0)
    after = cold.device.steps(cold.loop)[done:]
    assert after["reading_status"].tolist() == [0] * len(after)
    assert set(after["reading_raw"].tolist()) == {round(128 * ROOM_C)}
    assert cold.device.read("fault.code") == 0
    cold.chip.wire = "S"
    cold.device.sense(cold.sensor, ROOM_C + 4)
    cold.run(2.0)
    assert cold.device.steps(cold.loop)["reading_raw"][-1] == round(128 * (ROOM_C + 4))
    cold.send(f"#15 {K};")
    assert (cold.chosen, cold.chip.orders) == ((K, K), 6), "two orders when it is set up, and then"


def test_a_warm_kiln_jumps(cold: Cold) -> None:
    """4.096 mV above a junction at 25 °C is 124 °C for type K: for type S it is some 500 °C."""
    for warmer_c in range(30, 126, 5):
        cold.device.sense(cold.sensor, warmer_c)
        cold.run(1.0)
    assert cold.device.read("fault.code") == 0
    cold.send(CHOOSE_S)
    cold.run(1.0)
    assert cold.device.steps(cold.loop)["temperature_c"].max() > 150.0
    assert cold.device.read("fault.code") == 8


def test_not_while_a_program_runs_or_waits(cold: Cold) -> None:
    for order, code in (("start", K), ("pause", K), ("stop", S)):
        cold.device.program(order, 1)
        cold.run(2.0)
        cold.send(CHOOSE_S)
        assert cold.chosen == (code, code)


def test_not_when_it_is_switched_before_the_next_step_sees_it(cold: Cold) -> None:
    for order in (f"#2 1;{CHOOSE_S}", f"#2 0;{CHOOSE_S}"):
        cold.send(order)
        assert cold.chosen == (K, K)
