"""The safety relay behind the real gate: switched without load, told from a weld by its contact."""

import random
from collections.abc import Iterator
from itertools import repeat
from typing import NamedTuple

import pytest
from rig.outputs import LATE_S, TICK_S, OutputBoard, Wired, cause_problem, reset_problem, wired

from heatwright.sim.binary.elf import Elf
from heatwright.sim.native.relay import Armature, Relay, Wire

PINS = {"uno": ("D3", "D7", "D8"), "mega2560": ("D6", "D9", "D17"),
        "atmega32": ("PD5", "PD6", "PC1")}  # fmt: skip
"""Heater's, relay's and contact's; ports beyond the reach of `sbi` among them."""
OPERATE_S, RELEASE_S = 0.022, 0.012
"""So that the contact is, at a tick, where it was LATE_S after the one before."""
SETTLE_TICKS, CONTACT_TICKS = 5, 10
MAIN_TICKS = 10
"""The main loop's permit."""
WELDED, OPEN = 25, 26
JUDGED_C = 21.0
"""The temperature that the program gives with a judgement."""


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
    """What heater and relay do, from docs/safety.md."""

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
        # The first tick comes 10 ms after the clock was started, some microseconds after the reset.
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
