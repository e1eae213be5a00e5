"""What LEDs show of a loop and of its master: lit, blinking or dark, as a person tells it.

They are on a small oven whose temperature and current are in the test's hand.
"""

from collections.abc import Callable
from itertools import pairwise

import pytest
from rig.firmware import device_of

from heatwright.sim.binary.elf import Elf
from heatwright.sim.circuits import Wiring
from heatwright.sim.interfaces.indicators import Indicators, Led, Light
from heatwright.sim.interfaces.modbus_rtu import frames
from heatwright.sim.native.characters import Format

SPEC = """
heatwright: 1
controller: {name: shown, board: uno}
sensors:
  block:
    {kind: thermistor, pin: A0, divider: {pull_up: 4.7 kΩ}, range: 0 °C .. 300 °C, oversample: 16,
     curve: {resistance: 100 kΩ, at: 25 °C, beta: 4092 K}}
  amps: {kind: current, pin: A1, scale: 0.2 V/A, offset: 0.5 V}
outputs:
  heater:
    {kind: pwm, pin: D9, frequency: 1 kHz, power: 76.6 W, supply: 43 V,
     current: {sensor: amps, limit: 3 A, trip: 9 A}}
  cooler: {kind: digital, pin: D7}
loops:
  block:
    {sensor: block, heater: heater, cooler: cooler, period: 200 ms,
     setpoint: {initial: 100 °C, minimum: 10 °C, maximum: 250 °C},
     algorithm: {kind: three_position, dead_band: 2 K},
     protection: {maximum: 280 °C, minimum: 5 °C, rise_rate: 200 K/s, stale_after: 5 s}}
safety: {watchdog: 1 s}
interfaces:
"""
LEDS = """\
  - kind: indicators
    leds: {D10: enabled, D11: heating, D12: cooling, D13: warm, D2: fault, D3: fault}
    active: high
"""
MASTER = """\
  - {kind: modbus_rtu}
  - {kind: indicators, leds: {D10: enabled, D11: communicating}}
"""
LOOP, LOOP_LOW = SPEC + LEDS, SPEC + LEDS.replace("high", "low")
HOSTED = SPEC + MASTER
IMPATIENT = HOSTED.replace("stale_after: 5 s", "stale_after: 5 s, master_lost_after: 3 s")
"""The same with the rule `master_lost`."""
FULL_A = 76.6 / 43
STEP_S = 0.1
FASTEST_K = 10.0  # Change of the temperature in a step; `rise_rate` allows twice that
SETTLED_S = 4.0  # A step of the loop or some, the current's soft start, and two seconds of looking


class Shown:
    """The board, its sensors fed by hand; `strength` is the heater's current, in its own."""

    def __init__(self, text: str, elf: Elf | None = None) -> None:
        self.device = device_of(text, elf=elf)
        self.strength = 1.0
        self.temperature_c = self._felt_c = 20.0
        self._now_s = 0.0
        (indicators,) = (each for each in self.device.interfaces if isinstance(each, Indicators))
        self._indicators = indicators

    @property
    def leds(self) -> list[Led]:
        self.device.feed()
        return list(self._indicators.leds.values())

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / STEP_S)):
            share = self.device.on_fraction("heater")
            self.device.sense("amps", FULL_A * self.strength * share)
            self._felt_c += max(-FASTEST_K, min(FASTEST_K, self.temperature_c - self._felt_c))
            self.device.sense("block", self._felt_c)
            self._now_s += STEP_S
            self.device.advance(self._now_s)

    def lights(self, seconds: float = SETTLED_S) -> dict[str, Light]:
        self.run(seconds)
        self.device.feed()
        return self._indicators.lights()

    def at(self, temperature_c: float, strength: float = 1.0) -> dict[str, Light]:
        self.temperature_c, self.strength = temperature_c, strength
        return self.lights()

    def open_sensor(self) -> None:
        self.device.sensors["block"].wiring = Wiring(opened=True)  # type: ignore[attr-defined]

    def ask_another(self) -> None:
        request = frames.framed(2, frames.read(4, 0, 1))
        self.device.avr.uarts[0].send(request, 19_200, Format(8, "even", 1))


COLD = {"enabled": "lit", "heating": "lit", "cooling": "dark", "warm": "blinking", "fault": "dark"}
HELD_BACK = COLD | {"heating": "blinking"}
NEAR = COLD | {"heating": "dark", "warm": "lit"}
HOT = COLD | {"heating": "dark", "cooling": "lit"}
LOST = COLD | {"heating": "dark"}  # no reading, and not yet for so long that it is a fault
BROKEN_OFF = {
    "enabled": "blinking", "heating": "dark", "cooling": "lit", "warm": "dark", "fault": "blinking",
}  # fmt: skip
"""Nobody knows how hot it is, so it is cooled."""


@pytest.fixture(params=[LOOP, LOOP_LOW], ids=["high", "low"])
def shown(request: pytest.FixtureRequest) -> Shown:
    return Shown(request.param)


def test_each_state_has_its_lights(shown: Shown) -> None:
    for celsius, expected in ((20.0, COLD), (99.0, NEAR), (110.0, HOT), (101.0, NEAR)):
        assert shown.at(celsius) == expected
    assert shown.at(60.0) == COLD
    assert shown.at(60.0, strength=3.0) == HELD_BACK
    assert shown.at(60.0) == COLD
    shown.open_sensor()
    assert shown.lights() == LOST
    assert shown.lights() == BROKEN_OFF


def test_blinking_is_half_a_second_each_way_to_the_tick(shown: Shown) -> None:
    shown.open_sensor()
    shown.run(14.0)
    seen = []
    for led in shown.leds:
        changes = [at_s for at_s, _ in led.changes if at_s > 6.0]
        if led.meaning in {"enabled", "fault"}:
            gaps = [late - early for early, late in pairwise(changes)]
            assert gaps == pytest.approx([0.5] * len(gaps), abs=1e-3)
            assert len(gaps) >= 8
            seen.append([round(at_s, 3) for at_s in changes])
    assert seen == 3 * seen[:1], "they blink together"


def test_they_are_dark_from_the_reset_on_until_there_is_something_to_show(shown: Shown) -> None:
    for until_s, may_shine in ((0.005, set()), (0.1, {"enabled", "warm"})):  # the first tick: 10 ms
        shown.device.advance(until_s)
        bright = {led.meaning for led in shown.leds if any(on for _, on in led.changes)}
        assert bright <= may_shine


@pytest.mark.parametrize(
    ("changes", "light"),
    [
        ([(1.0, True)], "lit"), ([(1.0, True), (8.1, False)], "unsteady"),
        ([(0.5 * n, n % 2 == 0) for n in range(1, 21)], "blinking"),
        ([(0.25 * n, n % 2 == 0) for n in range(1, 41)], "unsteady"),
        ([(1.0 * n, n % 2 == 0) for n in range(1, 11)], "unsteady"),
        ([(0.5 * n, n % 2 == 0) for n in range(1, 19)], "unsteady"),
    ],
)  # fmt: skip
def test_neither_steady_nor_even_light_is_blinking(
    changes: list[tuple[float, bool]], light: Light
) -> None:
    led = Shown(LOOP).leds[0]
    led.changes = [(0.0, False), *changes]
    assert led.light(10.0) == light


SILENT_S = {HOSTED: 5.0, IMPATIENT: 3.0}
"""After so long the master is lost: by default, and by the rule."""
with_a_master = pytest.mark.parametrize("text", SILENT_S, ids=["usual", "impatient"])
BLINK_S = 0.5


def it_hears_its_master(shown: Shown) -> None:
    """Once it is there it reads once a second; a question to another board is none to this."""
    master = shown.device.master
    for deed, seconds, light in (
        (master.unplug, 6.0, "dark"), (shown.ask_another, 6.0, "dark"), (master.plug, 5.0, "lit"),
        (master.unplug, 8.0, "blinking"), (shown.ask_another, 2.2, "blinking"),
        (master.plug, 5.0, "lit"),
    ):  # fmt: skip
        deed()
        assert shown.lights(seconds)["communicating"] == light


@with_a_master
def test_it_is_lost_after_the_time_that_the_rule_gives(text: str) -> None:
    shown = Shown(text)
    shown.run(2.5)
    shown.device.master.unplug()
    heard_s = 2.0 + 0.1  # the last of the reads, once a second, and its answer
    shown.run(SILENT_S[text] + 2.0)
    (led,) = (each for each in shown.leds if each.meaning == "communicating")
    first_s = next(at_s for at_s, bright in led.changes if at_s > heard_s and not bright)
    # It blinks from then on, wherever the blink is.
    assert SILENT_S[text] - 0.2 <= first_s - heard_s <= SILENT_S[text] + BLINK_S


def it_is_switched_by_its_master(shown: Shown) -> None:
    assert shown.lights()["enabled"] == "dark"  # a loop with a master is off at the start
    for on, light in ((True, "lit"), (False, "dark")):
        shown.device.write("block.enabled", on)
        assert shown.lights()["enabled"] == light


@with_a_master
@pytest.mark.parametrize("check", [it_hears_its_master, it_is_switched_by_its_master])
def test_beside_a_master(text: str, check: Callable[[Shown], None]) -> None:
    check(Shown(text))
