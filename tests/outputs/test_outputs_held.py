"""Heater and cooler behind the real gate: minimum times and the interlock, tick by tick."""

import random
from collections.abc import Mapping
from typing import Any, NamedTuple

import pytest
from rig.outputs import LATE_S, TICK_S, OutputBoard, Wired, wired

from heatwright.sim.binary.elf import Elf
from heatwright.sim.reference.outputs.held import Held, held_of
from heatwright.spec import DigitalOutput

PINS = {"uno": ("D3", "D7"), "mega2560": ("D6", "D9"), "atmega32": ("PD5", "PD6")}
"""Heater's and cooler's; a port beyond the reach of `sbi` among them."""
KINDS = {
    "pwm": "kind: pwm, frequency: 976.5625 Hz",
    "pwm by interrupts": "kind: pwm, frequency: 100 Hz",
    "windows": "kind: time_proportional, window: 1 s",
}
"""Other heaters than a digital one."""
VARIANTS = {
    "none": ("", ""),
    "on": (", minimum_on: 150 ms", ""),
    "off": (", minimum_off: 120 ms", ""),
    "both": (", minimum_on: 70 ms, minimum_off: 90 ms", ""),
    "cooler": ("", ", minimum_on: 110 ms, minimum_off: 50 ms"),
    "all": (", minimum_on: 60 ms, minimum_off: 40 ms", ", minimum_on: 80 ms, minimum_off: 70 ms"),
    "low": (", active: low, minimum_on: 60 ms", ", active: low, minimum_off: 40 ms"),
}
LATCHED = 6
"""A fault's code, whichever."""


class Orders(NamedTuple):
    """What there is in a tick: a fault, or what the program asks for."""

    heater: bool
    cooler: bool
    latched: bool = False
    stop: bool = False


HEAT = Orders(heater=True, cooler=False)
COOL = Orders(heater=False, cooler=True)
NONE = Orders(heater=False, cooler=False)


def held(heater: str = "", cooler: str = "", *, board: str = "uno", kind: str = "") -> Wired:
    pins = PINS[board]
    outputs = {
        "heater": f"{KINDS.get(kind, 'kind: digital')}, pin: {pins[0]}, power: 40 W{heater}",
        "cooler": f"kind: digital, pin: {pins[1]}{cooler}",
    }
    return wired(board, outputs, gate=True)


class HeldBoard(OutputBoard):
    def __init__(self, place: Wired, elf: Elf | None = None) -> None:
        super().__init__(place, elf)
        self.stops = "output_heater_stop" in self.program.symbols
        outputs: Mapping[str, Any] = self.controller.outputs
        self.models: dict[str, Held] = {
            name: held_of(each) if isinstance(each, DigitalOutput) else Held(0, 0)
            for name, each in outputs.items()
        }
        self._started = False
        self.percent = 100
        self._last = dict.fromkeys(self.outputs, False)
        # The first tick comes 10 ms after the clock was started, some microseconds after the reset.
        self.avr.run(LATE_S)

    def tick(self, orders: Orders) -> tuple[tuple[bool, bool], tuple[bool, bool]]:
        """Go on to just after the next tick; return what is on, and what should be.

        The tick's interrupt switches by the orders before; then the program takes these.
        """
        self.put("fault.code", LATCHED * orders.latched)
        self.ask("heater", self.percent * orders.heater)
        self.ask("cooler", 100.0 * orders.cooler)
        if self.stops:
            self.put("heater_stop", orders.stop)
        self.avr.run(TICK_S)
        heater, cooler = self.models["heater"], self.models["cooler"]
        heater.tick(permitted=not orders.latched and self._started and not cooler.on)
        cooler.tick(permitted=not heater.on)
        heater.set(asked=orders.heater)
        cooler.set(asked=orders.cooler)
        if orders.stop and self.stops:
            heater.stop()
        self._started = True
        return self.seen(), (heater.on, cooler.on)

    def seen(self) -> tuple[bool, bool]:
        return self.outputs["heater"].on, self.outputs["cooler"].on

    def told(self) -> tuple[bool, bool]:
        return bool(self.get("heater_told")), bool(self.get("cooler_told"))

    def overlap(self) -> int:
        """Return how often both were on at once, by the pins' own changes, since the last call."""
        both = 0
        for change in self.changes():
            self._last[change.name] = change.on
            both += all(self._last.values())
        return both


def course(seed: int, ticks: int) -> list[Orders]:
    """Draw orders that mostly stay as they are, and sometimes contradict each other."""
    drawn = random.Random(seed)  # noqa: S311 - no secret
    orders = NONE
    found = []
    for _ in range(ticks):
        if drawn.random() < 0.2:
            orders = orders._replace(heater=drawn.random() < 0.5)
        if drawn.random() < 0.2:
            orders = orders._replace(cooler=drawn.random() < 0.5)
        orders = orders._replace(latched=drawn.random() < 0.03, stop=drawn.random() < 0.03)
        found.append(orders)
    return found


def problem(bench: HeldBoard, orders: list[Orders]) -> str:
    for number, each in enumerate(orders):
        seen, due = bench.tick(each)
        if seen != due:
            return f"tick {number}: heater and cooler are {seen}, not {due}"
        if bench.told() != due:
            return f"tick {number}: it is said that they are {bench.told()}"
    return "both on at once" if bench.overlap() else ""


def any_orders_problem(place: Wired, elf: Elf | None = None, seeds: int = 3) -> str:
    for first in (HEAT, COOL):
        if found := problem(HeldBoard(place, elf), [first] * 30):
            return found
    bench = HeldBoard(place, elf)
    bench.percent = 1  # any duty is on
    return "".join(problem(bench, course(seed, 400)) for seed in range(seeds))


def timed_problem(place: Wired, elf: Elf | None = None, percent: int = 37) -> str:
    """Say what is wrong with a heater of pulses: it never overlaps with the cooler."""
    bench = HeldBoard(place, elf)
    bench.percent = percent
    windows = place.controller.outputs["heater"].kind == "time_proportional"
    first = [HEAT] * 101 * windows  # orders come after the first tick
    seen_on, latched = 0, False
    for number, each in enumerate(first + course(percent, 600)):
        (heater, _), due = bench.tick(each)
        if windows:  # in a pause it is off, and the cooler may be on
            bench.models["heater"].on, bench.models["cooler"].on = due = bench.told()
            seen_on += heater
            if number == 100 and seen_on != percent:
                return f"on for {seen_on} ticks"
            if heater and latched:
                return "on with a fault latched"
        latched = each.latched
        if bench.told() != due or (windows and bench.seen() != due):
            return f"tick {number}: it is said that they are {bench.told()}, not {due}"
    return "both on at once" if bench.overlap() else ""


@pytest.mark.parametrize("board", PINS)
@pytest.mark.parametrize("variant", VARIANTS)
def test_any_orders(board: str, variant: str) -> None:
    assert any_orders_problem(held(*VARIANTS[variant], board=board)) == ""


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("percent", [1, 37, 99, 100])
def test_no_other_heater_overlaps_with_the_cooler(kind: str, percent: int) -> None:
    place = held(cooler=", minimum_on: 30 ms", kind=kind)
    assert timed_problem(place, percent=percent) == ""
