"""What LEDs show of a loop and of its master: lit, blinking or dark, as a person tells it."""

from itertools import pairwise

import pytest
from indicated_board import IMPATIENT, LEDS, MASTER, Shown

from heatwright.sim.elf import Elf
from heatwright.sim.interfaces import modbus_frames as frames
from heatwright.sim.native.characters import Format

COLD = {"enabled": "lit", "heating": "lit", "cooling": "dark", "warm": "blinking", "fault": "dark"}
HELD_BACK = COLD | {"heating": "blinking"}
NEAR = COLD | {"heating": "dark", "warm": "lit"}
HOT = COLD | {"heating": "dark", "cooling": "lit"}
LOST = COLD | {"heating": "dark"}
"""No reading, and not yet for so long that it is a fault."""
BROKEN_OFF = {
    "enabled": "blinking", "heating": "dark", "cooling": "lit", "warm": "dark", "fault": "blinking",
}  # fmt: skip
"""Nobody knows how hot it is, so it is cooled."""


@pytest.fixture(params=["high", "low"])
def shown(request: pytest.FixtureRequest) -> Shown:
    return Shown(LEDS, request.param)


def test_each_state_has_its_lights(shown: Shown) -> None:
    assert shown.at(20.0) == COLD
    assert shown.at(99.0) == NEAR
    assert shown.at(110.0) == HOT
    assert shown.at(101.0) == NEAR
    assert shown.at(60.0) == COLD
    assert shown.at(60.0, strength=3.0) == HELD_BACK
    assert shown.at(60.0) == COLD
    shown.open_sensor()
    assert shown.lights() == LOST
    assert shown.lights() == BROKEN_OFF


def test_blinking_is_half_a_second_each_way_to_the_tick(shown: Shown) -> None:
    shown.open_sensor()
    shown.run(14.0)
    shown.device.feed()
    times = {}
    for led in shown.leds.leds.values():
        changes = [at_s for at_s, _ in led.changes if at_s > 6.0]
        if led.meaning in {"enabled", "fault"}:
            gaps = [late - early for early, late in pairwise(changes)]
            assert gaps == pytest.approx([0.5] * len(gaps), abs=1e-3)
            assert len(gaps) >= 8
            times[led.pin] = [round(at_s, 3) for at_s in changes]
    assert len(times) == 3
    assert len(set(map(tuple, times.values()))) == 1, "they blink together"


def test_they_are_dark_from_the_reset_on_until_there_is_something_to_show() -> None:
    shown = Shown()
    shown.device.feed()
    assert not any(led.changes[-1][1] for led in shown.leds.leds.values())
    shown.device.advance(0.1)
    shown.device.feed()
    bright = {led.meaning for led in shown.leds.leds.values() if led.changes[-1][1]}
    assert bright <= {"enabled", "warm"}


def test_neither_steady_nor_even_light_is_blinking() -> None:
    shown = Shown()
    led = next(iter(shown.leds.leds.values()))
    for changes, light in (
        ([(0.0, False), (1.0, True)], "lit"),
        ([(0.0, False), (1.0, True), (8.1, False)], "unsteady"),
        ([(0.0, False), *((0.5 * n, n % 2 == 0) for n in range(1, 21))], "blinking"),
        ([(0.0, False), *((0.25 * n, n % 2 == 0) for n in range(1, 41))], "unsteady"),
        ([(0.0, False), *((1.0 * n, n % 2 == 0) for n in range(1, 11))], "unsteady"),
        ([(0.0, False), *((0.5 * n, n % 2 == 0) for n in range(1, 19))], "unsteady"),
    ):
        led.changes = changes
        assert led.light(10.0) == light


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
