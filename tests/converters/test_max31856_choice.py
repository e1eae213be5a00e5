"""The operator chooses the thermocouple's type on the touch display: the kiln's binary."""

from typing import NamedTuple

import pytest
from rig.avr import whole
from rig.specs import example

from heatwright.sim.device import AvrDevice
from heatwright.sim.sensors.max31856 import Max31856

J, K, S = 2, 3, 6
"""Codes of types; the operator may choose K and S."""
ROOM_C = 25.0
SAVED_S = 15.0
"""Until a choice is in the EEPROM: it waits 10 s for another one."""


class Cold(NamedTuple):
    """A machine at room temperature, where every type reads the same."""

    device: AvrDevice
    sensor: str
    loop: str

    def begin(self) -> None:
        """Let it read."""
        self.device.sense(self.sensor, ROOM_C)
        self.run(3.02)

    def run(self, seconds: float) -> None:
        """Go on."""
        self.device.advance(self.device.time_s + seconds)

    @property
    def chip(self) -> Max31856:
        """Return the converter."""
        found = self.device.sensors[self.sensor]
        assert isinstance(found, Max31856)
        return found

    def choose(self, code: int) -> None:
        """Choose a type on the display."""
        self.send(f"#15 {code};")

    def send(self, order: str) -> None:
        """Send what the display sends, and let it be heard."""
        self.device.send(order)
        self.run(2.0)

    def program(self, *order: str | int) -> None:
        """Order a program about."""
        self.device.program(*order)  # type: ignore[arg-type]
        self.run(2.0)

    @property
    def chosen(self) -> tuple[int, int]:
        """Return what the settings say, and the chip."""
        setting = int(self.device.read(f"settings.{self.sensor}_thermocouple"))
        return setting, self.chip._registers[1] & 0xF


@pytest.fixture
def cold() -> Cold:
    """The kiln."""
    found = Cold(AvrDevice(example("kiln").controller, whole("kiln")), "chamber", "chamber")
    found.begin()
    return found


def test_it_is_taken_over_with_the_next_reading(cold: Cold) -> None:
    assert cold.chosen == (K, K)
    done = len(cold.device.steps(cold.loop))
    cold.choose(S)
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


def test_a_warm_kiln_jumps(cold: Cold) -> None:
    """4.096 mV above a junction at 25 °C is 124 °C for type K: for type S it is some 500 °C."""
    for warmer_c in range(30, 126, 5):
        cold.device.sense(cold.sensor, warmer_c)
        cold.run(1.0)
    assert cold.device.read("fault.code") == 0
    cold.choose(S)
    cold.run(1.0)
    assert cold.device.steps(cold.loop)["temperature_c"].max() > 150.0
    assert cold.device.read("fault.code") == 8


@pytest.mark.parametrize("code", [J, 8, 255, 256 + S])
def test_only_what_may_be_chosen(cold: Cold, code: int) -> None:
    cold.choose(code)
    assert cold.chosen == (K, K)


def test_not_while_a_program_runs_or_waits(cold: Cold) -> None:
    cold.program("start", 1)
    cold.choose(S)
    assert cold.chosen == (K, K)
    cold.program("pause")
    cold.choose(S)
    assert cold.chosen == (K, K)
    cold.program("stop")
    cold.choose(S)
    assert cold.chosen == (S, S)


def test_not_while_the_loop_is_on(cold: Cold) -> None:
    cold.send("#2 1;")
    assert cold.device.read(f"loop_{cold.loop}.enabled") == 1
    cold.choose(S)
    assert cold.chosen == (K, K)
    cold.send("#2 0;")
    cold.choose(S)
    assert cold.chosen == (S, S)


def test_not_when_it_is_switched_before_the_next_step_sees_it(cold: Cold) -> None:
    for order in ("#2 1;#15 6;", "#2 0;#15 6;"):
        cold.send(order)
        assert cold.chosen == (K, K)


def test_it_outlives_a_loss_of_power(cold: Cold) -> None:
    cold.choose(S)
    cold.run(SAVED_S)
    cold.device.power_cycle()
    cold.device.sense(cold.sensor, ROOM_C)
    cold.run(3.02)
    assert cold.chosen == (S, S)
    assert set(cold.device.steps(cold.loop)["reading_status"].tolist()) == {0}
