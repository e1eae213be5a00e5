"""The menu: walks through its C on this computer; and on the kiln's binary what only it can show:
keys at the ADC, the display's times, and what the EEPROM keeps."""

import pytest
from hosted_menu import WORLD, problem_of, walks
from rig.firmware import example, whole
from suite import amount

from heatwright.sim.device import AvrDevice
from heatwright.sim.scenario import PRESS_S

TYPE_S = 6  # the converter's code of the type (MAX31856 data sheet, CR1)


def test_walks_through_the_screens() -> None:
    world = WORLD.program()
    for seed, walk in enumerate(walks(amount("menu_walks"))):
        assert problem_of(world, walk) == "", seed


class Desk:
    """Somebody at the keys of the kiln on an Uno, which has an empty EEPROM and is at 20 °C."""

    def __init__(self) -> None:
        self.device = AvrDevice(example("kiln_uno").controller, whole("kiln_uno"))
        self.power_cycle()

    def power_cycle(self) -> None:
        self.device.power_cycle()
        self._until_s = self.device.time_s
        self.run(2.5)

    def run(self, seconds: float) -> None:
        self.device.sense("chamber", 20.0)
        self._until_s += seconds
        self.device.advance(self._until_s)

    def press(self, keys: str, for_s: float = PRESS_S) -> tuple[str, str]:
        for key in keys.split():
            self.device.press(key)
            self.run(for_s)
            self.device.press(None)
            self.run(PRESS_S)
        lcd = self.device.shield.lcd
        assert (lcd.chip.lost, lcd.violations) == (0, {})
        return lcd.text[0].rstrip(), lcd.text[1].rstrip()

    def read(self, *names: str) -> list[float]:
        return [self.device.read(name).item() for name in names]


def test_a_program_is_written_kept_and_run() -> None:
    """A key that is held goes on by itself, and in coarse steps from the twentieth time."""
    desk = Desk()
    assert desk.press("right right right up") == ("Edit program?", "2 (empty)")
    assert desk.press("select up select up right") == ("Segment 1", "to 0°C")
    assert desk.press("up", for_s=5.0) == ("Segment 1", f"to {1 + 19 + 10 * 26}°C")
    assert desk.press("right right down select") == ("SELECT: save", "LEFT: back")
    assert desk.press("select", for_s=2.0)[1] == "2 oew"
    desk.power_cycle()
    assert desk.press("right right up select") == ("SELECT: start", "2 oew")
    desk.press("select", for_s=1.2)
    assert desk.read(*(f"program.{each}" for each in ("state", "number", "segments"))) == [1, 2, 2]
    assert desk.press("left left") == ("20°C >20°C", "1/2 runs")


def test_values_are_kept_through_a_loss_of_power() -> None:
    desk = Desk()
    names = [f"settings.chamber_{each}" for each in ("kp", "ki", "maximum_c", "thermocouple")]
    kp, ki, maximum_c, _ = desk.read(*names)
    desk.press("left select select up select select down select select select")
    desk.press("down select select up select")
    desk.run(11.0)
    desk.power_cycle()
    assert desk.read(*names) == pytest.approx([kp * 1.05, ki / 1.05, maximum_c - 1.0, TYPE_S])
