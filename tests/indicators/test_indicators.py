"""What LEDs show: lit, blinking or dark, told from the pins as a person tells it."""

from itertools import pairwise

import pytest
from indicated_board import LEDS, Shown

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
