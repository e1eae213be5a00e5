"""Outputs behind the real gate: heater and cooler, and the safety relay, tick by tick."""

import random
from collections.abc import Iterator, Mapping
from itertools import repeat
from typing import Any, NamedTuple

import pytest
from rig.outputs import LATE_S, TICK_S, OutputBoard, Wired, cause_problem, reset_problem, wired

from heatwright.sim.binary.elf import Elf
from heatwright.sim.native.relay import Armature, Relay, Wire
from heatwright.sim.reference.outputs.course import Held, held_of
from heatwright.spec import DigitalOutput

PAIRS = {"uno": ("D3", "D7"), "mega2560": ("D6", "D9"), "atmega32": ("PD5", "PD6")}
"""Heater's and cooler's; a port beyond the reach of `sbi` among them."""
KINDS = {
    "pwm": "kind: pwm, frequency: 976.5625 Hz",
    "pwm by interrupts": "kind: pwm, frequency: 100 Hz",
    "windows": "kind: time_proportional, window: 1 s",
}
"""Other heaters than a digital one."""
VARIANTS = {
    "none": ("", ""), "on": (", minimum_on: 150 ms", ""), "off": (", minimum_off: 120 ms", ""),
    "both": (", minimum_on: 70 ms, minimum_off: 90 ms", ""),
    "cooler": ("", ", minimum_on: 110 ms, minimum_off: 50 ms"),
    "all": (", minimum_on: 60 ms, minimum_off: 40 ms", ", minimum_on: 80 ms, minimum_off: 70 ms"),
    "low": (", active: low, minimum_on: 60 ms", ", active: low, minimum_off: 40 ms"),
}  # fmt: skip
LATCHED = 6  # a fault's code, whichever


class Asked(NamedTuple):
    """What there is in a tick: a fault, or what the program asks for."""

    heater: bool
    cooler: bool
    latched: bool = False
    stop: bool = False


HEAT = Asked(heater=True, cooler=False)
COOL = Asked(heater=False, cooler=True)
NONE = Asked(heater=False, cooler=False)


def held(heater: str = "", cooler: str = "", *, board: str = "uno", kind: str = "") -> Wired:
    pins = PAIRS[board]
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

    def tick(self, orders: Asked) -> tuple[tuple[bool, bool], tuple[bool, bool]]:
        """Go on to just after the next tick; return what is on, and what should be. The tick's
        interrupt switches by the orders before; then the program takes these."""
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


def asked_course(seed: int, ticks: int) -> list[Asked]:
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


def held_problem(bench: HeldBoard, orders: list[Asked]) -> str:
    for number, each in enumerate(orders):
        seen, due = bench.tick(each)
        if seen != due:
            return f"tick {number}: heater and cooler are {seen}, not {due}"
        if bench.told() != due:
            return f"tick {number}: it is said that they are {bench.told()}"
    return "both on at once" if bench.overlap() else ""


def any_orders_problem(place: Wired, elf: Elf | None = None, seeds: int = 3) -> str:
    for first in (HEAT, COOL):
        if found := held_problem(HeldBoard(place, elf), [first] * 30):
            return found
    bench = HeldBoard(place, elf)
    bench.percent = 1  # any duty is on
    return "".join(held_problem(bench, asked_course(seed, 400)) for seed in range(seeds))


def timed_problem(place: Wired, elf: Elf | None = None, percent: int = 37) -> str:
    """Say what is wrong with a heater of pulses: it never overlaps with the cooler."""
    bench = HeldBoard(place, elf)
    bench.percent = percent
    windows = place.controller.outputs["heater"].kind == "time_proportional"
    first = [HEAT] * 101 * windows  # orders come after the first tick
    seen_on, latched = 0, False
    for number, each in enumerate(first + asked_course(percent, 600)):
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


@pytest.mark.parametrize("board", PAIRS)
@pytest.mark.parametrize("variant", VARIANTS)
def test_any_orders(board: str, variant: str) -> None:
    assert any_orders_problem(held(*VARIANTS[variant], board=board)) == ""


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("percent", [1, 37, 99, 100])
def test_no_other_heater_overlaps_with_the_cooler(kind: str, percent: int) -> None:
    place = held(cooler=", minimum_on: 30 ms", kind=kind)
    assert timed_problem(place, percent=percent) == ""


PINS = {"uno": ("D3", "D7", "D8"), "mega2560": ("D6", "D9", "D17"),
        "atmega32": ("PD5", "PD6", "PC1")}  # fmt: skip
"""Heater's, relay's and contact's; ports beyond the reach of `sbi` among them."""
OPERATE_S, RELEASE_S = 0.022, 0.012
"""So that the contact is, at a tick, where it was LATE_S after the one before."""
SETTLE_TICKS, CONTACT_TICKS = 5, 10
MAIN_TICKS = 10  # the main loop's permit
WELDED, OPEN = 25, 26
JUDGED_C = 21.0  # the temperature that the program gives with a judgement


class Orders(NamedTuple):
    """What the program does in a tick; `acknowledged` comes before the tick."""

    heater: bool = True
    wanted: bool = True
    closed: bool = False
    hangs: bool = False
    acknowledged: bool = False
    step_due: bool = False


STEP = Orders(step_due=True)


def relayed(board: str = "uno", *, feedback: bool = True, active: str = "low") -> Wired:
    heater, relay, contact = PINS[board]
    outputs = {
        "heater": f"kind: digital, pin: {heater}, active: {active}, power: 40 W",
        "contactor": f"kind: digital, pin: {relay}, active: {active}",
    }
    return wired(board, outputs, gate=True, feedback=contact if feedback else "")


class Model:
    def __init__(self, *, feedback: bool) -> None:
        self._feedback = feedback
        self.heater = self.relay = False
        self.fault = 0
        self._age = 0
        self._wrong = 0
        self._found = 0
        self._silent = MAIN_TICKS
        self._orders = Orders(heater=False, wanted=False, closed=True)

    def tick(self, *, says_open: bool, acknowledged: bool) -> None:
        """Go on by a tick of the interrupt, by the orders before it."""
        orders = self._orders
        if acknowledged:
            self.fault = 0
        self._age += 1
        if self._feedback:
            self._wrong = self._wrong + 1 if says_open == self.relay else 0
            if self._wrong >= CONTACT_TICKS:
                self._found = OPEN if self.relay else WELDED
        alive = self._silent < MAIN_TICKS
        self._silent += 1
        permitted = alive and not self.fault and orders.wanted and not orders.closed
        ready = self.relay and self._age >= SETTLE_TICKS and not self._found
        self.heater = permitted and ready and orders.heater
        sure = not self._feedback or (self._age >= CONTACT_TICKS and not self._wrong)
        relay = permitted and not self._found and (self.relay or sure)
        if relay != self.relay:
            self.relay, self._age = relay, 0

    def obey(self, orders: Orders) -> None:
        """Go on by a pass of the main loop, behind the interrupt."""
        if orders.hangs:
            return
        self._silent = 0
        self._orders = orders
        if orders.step_due and self._feedback and self._found:
            self.fault = self.fault or self._found
            self._found = 0


class RelayBoard(OutputBoard):
    def __init__(self, place: Wired, elf: Elf | None = None) -> None:
        super().__init__(place, elf)
        coil = self.outputs["contactor"]
        self._feedback = bool(place.feedback)
        self.contact = self.board.pins[PINS[place.board][2]].port_name
        self.relay = Relay(
            self.avr, coil.pin, self.contact if self._feedback else None,
            active_high=coil.active == "high", operate_s=OPERATE_S, release_s=RELEASE_S,
        )  # fmt: skip
        self.model = Model(feedback=self._feedback)
        self._on = {"heater": False, "contactor": False}
        # The interrupt itself may come some cycles sooner or later.
        self._settle_cycles = round((SETTLE_TICKS * TICK_S - 1e-4) * self.board.clock_hz)
        self._closed_at = 0
        self.avr.run(LATE_S)
        self.avr.pins.take()

    def tick(self, orders: Orders) -> str:
        """Go on to just after the next tick; say what is not as it should be."""
        if orders.acknowledged:
            self.put("fault.code", 0)
        self.put("hangs", orders.hangs)
        self.put("gate_closed", orders.closed)
        self.put("relay_wanted", orders.wanted)
        if self._feedback:
            self.put("relay_judged", orders.step_due)
        self.ask("heater", 100.0 * orders.heater)
        says_open = self._feedback and not self.avr.pins.level(self.contact)
        self.avr.run(TICK_S)
        self.model.tick(says_open=says_open, acknowledged=orders.acknowledged)
        self.model.obey(orders)
        seen = (*(self.outputs[name].on for name in self._on), int(self.get("fault.code")))
        due = (self.model.heater, self.model.relay, self.model.fault)
        if seen != due:
            return f"heater, relay and fault are {seen}, not {due}"
        return self._judge_order()

    def _judge_order(self) -> str:
        """See in the pins' own changes that the relay switches without load."""
        for cycle, name, on in self.changes():
            if name == "heater" and on and not self._on["heater"]:
                settled = cycle - self._closed_at >= self._settle_cycles
                if not self._on["contactor"] or not settled:
                    return "the heater came on before the relay had settled"
            if name == "contactor" and on != self._on["contactor"]:
                if self._on["heater"]:
                    return "the relay switched under load"
                self._closed_at = cycle
            self._on[name] = on
        return ""


def course(seed: int, ticks: int) -> Iterator[Orders]:
    """Draw orders that mostly stay as they are; a control step every tenth tick or so."""
    drawn = random.Random(seed)  # noqa: S311 - no secret
    orders = Orders()
    for _ in range(ticks):
        if drawn.random() < 0.03:
            orders = orders._replace(wanted=drawn.random() < 0.7)
        if drawn.random() < 0.05:
            orders = orders._replace(heater=drawn.random() < 0.7)
        yield orders._replace(
            closed=drawn.random() < 0.02, hangs=drawn.random() < 0.3,
            acknowledged=drawn.random() < 0.05, step_due=drawn.random() < 0.1,
        )  # fmt: skip


def breakages(seed: int) -> Iterator[tuple[Armature, Wire]]:
    """Draw what is broken from one tick to the next; mostly nothing."""
    drawn = random.Random(seed)  # noqa: S311 - no secret
    broken = Armature.SOUND, Wire.SOUND
    while True:
        if drawn.random() < 0.01:
            broken = Armature.SOUND, Wire.SOUND
            if drawn.random() >= 0.6:
                broken = drawn.choice(list(Armature)), drawn.choice(list(Wire))
        yield broken


def problem(bench: RelayBoard, orders: Iterator[Orders], seed: int | None = None) -> str:
    broken = breakages(seed) if seed is not None else repeat(None)
    for number, (each, failure) in enumerate(zip(orders, broken, strict=False)):
        if failure is not None:
            bench.relay.fail(*failure)
        if found := bench.tick(each):
            return f"tick {number}: {found}"
    return ""


def whole_problem(place: Wired, elf: Elf | None = None) -> str:
    bench = RelayBoard(place, elf)
    if not all(switch.driven for switch in bench.outputs.values()):
        return "not driven"
    # It stays on for longer than a byte counts ticks.
    sound = problem(bench, course(3, 800)) or problem(bench, iter([Orders()] * 300))
    if sound or not place.feedback:
        return sound
    if bench.get("fault.temperature_c"):
        return "tripped without a fault"
    torn = RelayBoard(place, elf)
    torn.relay.fail(Armature.SOUND, Wire.TORN)
    if found := problem(torn, iter([STEP] * 40)) or problem(bench, course(4, 1500), seed=5):
        return found
    said = (torn.get("fault.code"), torn.get("fault.temperature_c"))
    return "" if said == (WELDED, JUDGED_C) else f"a torn wire is {said}"


@pytest.mark.parametrize("feedback", [True, False])
@pytest.mark.parametrize("active", ["high", "low"])
@pytest.mark.parametrize("board", PINS)
def test_every_tick_is_as_it_should_be(board: str, active: str, *, feedback: bool) -> None:
    bench = RelayBoard(relayed(board, feedback=feedback, active=active))
    assert problem(bench, course(1, 1500), seed=2 if feedback else None) == ""


@pytest.mark.parametrize("active", ["high", "low"])
@pytest.mark.parametrize("board", PINS)
def test_a_reset_opens_it_first_thing(board: str, active: str) -> None:
    bench = RelayBoard(relayed(board, active=active))
    assert problem(bench, iter([Orders()] * 40)) == ""
    assert bench.outputs["contactor"].on
    assert reset_problem(bench, "contactor") == ""


@pytest.mark.parametrize("feedback", [True, False])
def test_nothing_is_wrong_with_the_whole(*, feedback: bool) -> None:
    assert whole_problem(relayed(feedback=feedback)) == ""


@pytest.mark.parametrize("board", PINS)
def test_what_caused_a_reset_is_told_once(board: str) -> None:
    assert cause_problem(relayed(board)) == ""
