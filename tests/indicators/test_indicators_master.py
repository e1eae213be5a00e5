"""What LEDs show of a master: heard, lost, never heard; and that it has switched the loop."""

import pytest
from indicated_board import IMPATIENT, MASTER, Shown

from heatwright.sim.elf import Elf
from heatwright.sim.interfaces import modbus_frames as frames
from heatwright.sim.native.characters import Format

SILENT_S = {MASTER: 5.0, IMPATIENT: 3.0}
"""After so long the master is lost: by default, and by the rule."""
BLINK_S = 0.5


def alone(interfaces: str, elf: Elf | None = None) -> Shown:
    """A board whose master is not there yet; once it is, it reads once a second."""
    shown = Shown(interfaces, elf=elf)
    shown.device.master.unplug()
    return shown


def talk_to_another(shown: Shown) -> None:
    request = frames.framed(2, frames.read(4, 0, 1))
    shown.device.avr.uarts[0].send(request, 19_200, Format(8, "even", 1))


def course(shown: Shown) -> list[str]:
    """Return what is shown when the master is not there, there, lost, and there again."""
    found = [shown.lights(6.0)["communicating"]]
    talk_to_another(shown)
    found.append(shown.lights(6.0)["communicating"])
    shown.device.master.plug()
    found.append(shown.lights(5.0)["communicating"])
    shown.device.master.unplug()
    found.append(shown.lights(8.0)["communicating"])
    talk_to_another(shown)
    found.append(shown.lights(2.2)["communicating"])
    shown.device.master.plug()
    found.append(shown.lights(5.0)["communicating"])
    return found


HEARD = ["dark", "dark", "lit", "blinking", "blinking", "lit"]


@pytest.mark.parametrize("interfaces", SILENT_S)
def test_a_master_is_heard_lost_and_heard_again(interfaces: str) -> None:
    assert course(alone(interfaces)) == HEARD


@pytest.mark.parametrize("interfaces", SILENT_S)
def test_it_is_lost_after_the_time_that_the_rule_gives(interfaces: str) -> None:
    shown = alone(interfaces)
    shown.device.master.plug()
    shown.run(2.5)
    shown.device.master.unplug()
    heard_s = 2.0 + 0.1  # the last of the reads, once a second, and its answer
    shown.run(SILENT_S[interfaces] + 2.0)
    shown.device.feed()
    led = next(each for each in shown.leds.leds.values() if each.meaning == "communicating")
    first_s = next(at_s for at_s, bright in led.changes if at_s > heard_s and not bright)
    # It blinks from then on, wherever the blink is.
    assert SILENT_S[interfaces] - 0.2 <= first_s - heard_s <= SILENT_S[interfaces] + BLINK_S


def test_switched_by_the_master() -> None:
    shown = Shown(MASTER)
    found = [shown.lights()["enabled"]]
    for on in (False, True):
        shown.device.write("block.enabled", on)
        found.append(shown.lights()["enabled"])
    assert found == ["lit", "dark", "lit"]
