"""Rules 33 and 34: what wrong readings and switches trip, and that healthy machines never do."""

import math
from collections.abc import Callable, Iterator, Sequence
from random import Random
from typing import NamedTuple

import numpy as np
import pytest
from any_machine.drawing import MACHINES, drawn_machine
from machines import events
from rig.firmware import changed, controller_of, example, whole
from suite import SEED, amount

from heatwright.sim.arrays.masks import afresh
from heatwright.sim.arrays.world import Logs, _Runs
from heatwright.sim.bench import ReferenceDevice, bench, step_of
from heatwright.sim.faults.bears import bears_c, room_c
from heatwright.sim.faults.healthy import AMBIENTS_C
from heatwright.sim.faults.peaks import SPREADING_S
from heatwright.sim.faults.site import Place, Site
from heatwright.sim.faults.starts import first_steps, setpoints_c
from heatwright.sim.faults.world import Weather, World
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.protection.rules import EFFORT_HIGH, EFFORT_LOW, EffortRule, Look
from heatwright.spec import Controller, Loop
from heatwright.spec.base import ReadOnlyDict
from heatwright.spec.loops import Effort, EffortBand, EffortLine
from heatwright.spec.physics.effort import band_percent
from heatwright.spec.physics.heated_loop import heated_loop
from heatwright.spec.rules import RULES


class Spread(NamedTuple):
    """How healthy machines of a kind differ, beside the plant's tolerance.

    supply -- voltage, of the one in the spec; codes -- of the rules that none of them trips.
    """

    supply: tuple[float, float]
    rooms_c: tuple[float, float]
    codes: frozenset[int]


WIDEST = Spread((0.85, 1.1), (5.0, 35.0), frozenset((EFFORT_HIGH, EFFORT_LOW)))
"""Where the effort's own numbers are the plant's."""
CHECKED = Spread((1.0, 1.0), AMBIENTS_C, frozenset(RULES))
"""Where `check` has looked at the numbers of all rules."""
SETTLED_S = 1200.0

LINE = EffortLine(-10.0, -10.0, 1.0, -20.0, 0.5)  # between T − 10 and T/2 − 20 %


def rule(*, high: float | None = 210.0, low: float | None = 60.0) -> EffortRule:
    line = LINE if high else LINE._replace(high_percent=math.inf, high_per_k=0.0)
    line = line if low else line._replace(low_percent=-math.inf, low_per_k=0.0)
    limits = {"high_percent": high, "low_percent": low}
    effort = Effort.model_validate({"for": "5 s"}).model_copy(update=limits)
    band = EffortBand(9.0, 2.0, (line,))
    return EffortRule(effort.with_band(band), Loop.model_construct(period_s=1.0))


def begun(*, high: float | None = 210.0, low: float | None = 60.0) -> EffortRule:
    """A rule that has seen power and reading fit for long."""
    effort = rule(high=high, low=low)
    assert not any(stepped(effort, 60.0, 30.0, 100))
    return effort


def stepped(
    effort: EffortRule, celsius: float, duty: float, steps: int = 1, *, cooled: bool = False
) -> list[int]:
    found = []
    for _ in range(steps):
        effort.feel(Single(duty))
        t, asked = Single(celsius), Single(duty)
        look = Look(t, t, 1, 0, t, asked, asked, Single(100), cooled=cooled)
        found.append(effort.check(look))
    return found


def test_too_little_trips_after_its_time_and_no_step_before() -> None:
    effort = rule()
    assert stepped(effort, 60.0, 0.0, 6) == [0, 0, 0, 0, 0, EFFORT_LOW]  # the first has moved


def test_too_much_trips_and_what_fits_begins_the_time_anew() -> None:
    effort = begun()
    found = stepped(effort, 60.0, 80.0, 30)
    assert set(found[:-1]) <= {0, EFFORT_HIGH}
    assert effort.values()[0] > 50
    assert found[-1] == EFFORT_HIGH
    first = found.index(EFFORT_HIGH)
    effort = begun()
    assert not any(stepped(effort, 60.0, 80.0, first))
    stepped(effort, 60.0, 0.0, 5)
    assert not any(stepped(effort, 60.0, 80.0, 5))


def test_what_is_cooled_needs_more_and_begins_the_time_anew() -> None:
    effort = begun()
    assert not any(stepped(effort, 60.0, 80.0, 300, cooled=True))
    assert stepped(effort, 60.0, 80.0, 5) == [0, 0, 0, 0, EFFORT_HIGH]
    effort = begun()
    for _ in range(50):
        assert not any(stepped(effort, 60.0, 80.0, 4))
        assert not any(stepped(effort, 60.0, 80.0, cooled=True))


def test_a_reading_that_moves_counts_for_nothing_and_takes_the_power_along() -> None:
    effort = begun()
    for celsius in np.arange(60, 20, -2.0):
        assert not any(stepped(effort, float(celsius), 100.0))
        assert effort.values()[0] <= celsius - 10 + 9.1
    assert stepped(effort, 22.0, 100.0, 9)[-1] == EFFORT_HIGH


@pytest.mark.parametrize(("high", "low"), [(210.0, 60.0), (None, 60.0), (210.0, None)])
def test_what_is_no_number_trips(high: float | None, low: float | None) -> None:
    effort = begun(high=high, low=low)
    effort._percent = Single(math.nan)
    assert stepped(effort, 60.0, 30.0, 5)[-1] == (EFFORT_HIGH if high else EFFORT_LOW) or not high
    effort = begun(high=high, low=low)
    effort._from_c = Single(math.nan)
    assert not any(stepped(effort, 60.0, 30.0, 100))
    assert effort.values()[1] == 60


def test_nothing_fades_away() -> None:
    effort = rule(low=None)
    stepped(effort, 15.0, 50.0, 5)
    stepped(effort, 15.0, 0.0, 3000)
    assert 1e-13 < effort.values()[0] < 1e-10


def test_the_band_is_that_of_tolerance_and_supply() -> None:
    assert (band_percent(0.3), band_percent(0.1)) == ((210.0, 60.0), (170.0, 71.0))


def test_lines_are_what_the_plant_takes() -> None:
    controller = example("hotplate").controller
    loop, plant = controller.loops["plate"], controller.simulation.plant
    effort = loop.protection.effort
    per_k = 100 / 500 / plant.links[0].resistance_k_per_w
    coldest_c = min(5.0, loop.protection.minimum_c)
    high, low = effort.band.at(200.0)
    assert high == pytest.approx(2.1 * per_k * (200 - coldest_c))
    assert low == pytest.approx(0.6 * per_k * (200 - 40))
    assert effort.band.filter_s == pytest.approx(900 + 5, rel=1e-3)


def test_bent_lines_keep_near_the_curve() -> None:
    controller = example("kiln").controller
    band = controller.loops["chamber"].protection.effort.band
    heated = heated_loop(controller, "chamber", controller.simulation)
    assert 1 < len(band.lines) <= 8
    for celsius in range(100, 1150, 50):
        exact = 0.6 * 100 / heated.power_w * heated.at(35.0).power_w(celsius - 40.0)
        assert band.at(celsius)[1] == pytest.approx(exact, abs=1.0)


def test_where_it_would_see_nothing_it_is_off() -> None:
    found = {
        name: example(name).controller.loops[loop].protection.effort
        for name, loop in (("dryer", "air"), ("incubator", "air"), ("chamber", "air"))
    }
    assert found["dryer"] is found["incubator"] is None  # no room; nothing on a summer's day
    assert (found["chamber"].high_percent, found["chamber"].low_percent) == (None, 60)


Feel = Callable[[float, float], float]
"""What a sensor feels, by the time since it has failed, s, and by what it would feel."""


class Broken(ReferenceDevice):
    """A controller whose sensor or switch fails when the machine has settled."""

    def __init__(self, controller: Controller, feel: Feel, leak: float) -> None:
        super().__init__(controller)
        (loop,) = controller.loops.values()
        self._heater, self._feel, self._leak, self._after_s = loop.heater, feel, leak, -SETTLED_S

    def advance(self, until_s: float) -> None:
        self._after_s = until_s - SETTLED_S
        super().advance(until_s)

    def sense(self, sensor: str, felt: float) -> None:
        super().sense(sensor, self._feel(self._after_s, felt) if self._after_s > 0 else felt)

    def on_fraction(self, output: str) -> float:
        on = super().on_fraction(output)
        leaks = output == self._heater and self._after_s > 0
        return on + self._leak * (1 - on) if leaks else on


def drifts(after_s: float, felt_c: float) -> float:
    return felt_c - 0.05 * after_s


def creeps(after_s: float, felt_c: float) -> float:
    """Out of its place in 20 minutes, until it shows a third of the rise."""
    return 20 + (felt_c - 20) * (1 - 0.67 * min(1.0, after_s / 1200))


class Stands:
    def __init__(self) -> None:
        self._stood_c = math.nan

    def __call__(self, _: float, felt_c: float) -> float:
        if math.isnan(self._stood_c):
            self._stood_c = felt_c + 1.0
        return self._stood_c


class Failure(NamedTuple):
    """What is asked of an example, how it fails, and what must trip; leak -- share of the power."""

    example: str
    setpoint_c: float
    hours: float
    feel: Callable[[], Feel]
    leak: float
    codes: set[int]


FAILURES = [
    # its air came to 94 °C, and stayed there
    Failure("chamber", 50.0, 3.0, Stands, 1.0, {EFFORT_LOW}),
    # a switch that leaks 45 % while the reading drifts: 379 °C
    Failure("extruder", 200.0, 1.0, lambda: drifts, 0.45, {11, EFFORT_LOW}),
    Failure("extruder", 200.0, 1.0, lambda: drifts, 0.28, {EFFORT_LOW}),
    Failure("hotplate", 100.0, 2.0, lambda: drifts, 0.0, {EFFORT_HIGH}),
    Failure("hotplate", 80.0, 2.0, lambda: creeps, 0.0, {EFFORT_HIGH}),
]


@pytest.mark.parametrize("failure", FAILURES, ids="{0.example}-{0.setpoint_c}-{0.leak}".format)
def test_wrong_readings_and_switches_end_before_a_node_is_too_hot(failure: Failure) -> None:
    controller = example(failure.example).controller
    (loop,) = controller.loops
    device = Broken(controller, failure.feel(), failure.leak)
    device.ask(loop, failure.setpoint_c)
    trace = bench(controller, device, events({"for": f"{failure.hours} h"}))
    log, bears = trace.steps[loop], bears_c(controller, controller.simulation.plant)
    assert log["fault.code"][-1] in failure.codes
    spread_s = log["time_s"][(log["fault.code"] > 0).argmax()] + SPREADING_S
    for node, course_c in trace.temperatures_c.items():
        assert course_c[trace.times_s < spread_s].max() <= bears[node], node


WIDE = changed(
    MACHINES["glue_oven"], ("hysteresis: 4 K", "hysteresis: 12 K"),
    ("runaway: {above: 4.4 K, for: 4 s}", "runaway: {above: 40 K}"),
    ("rise_rate: 3 K/s", "rise_rate: 50 K/s"), ("      heating: {rise: 4 K, within: 7 s}\n", ""),
)  # fmt: skip
SLOW_S = 1.3 * 200 * 1.3 * 0.6
"""Time constant of the slowest machine of its kind, which cools in a warm room."""


@pytest.mark.parametrize(("maximum_c", "hysteresis_k"), [(60, 12), (90, 12), (100, 16), (120, 8)])
def test_a_wide_hysteresis_is_no_leak_wherever_it_is_switched_off(
    maximum_c: int, hysteresis_k: int
) -> None:
    """So long a reading that falls by less than it swings has less power than it takes."""
    text = WIDE.replace("90 °C", f"{maximum_c} °C").replace("12 K", f"{hysteresis_k} K")
    effort = controller_of(text).loops["air"].protection.effort
    assert effort is not None
    longest_s = max(falls_s(effort, off_c) for off_c in range(40, maximum_c + hysteresis_k))
    assert 0 < longest_s < effort.for_s


def test_a_loop_that_switches_through_a_long_window_is_not_watched_unless_asked() -> None:
    """Much else is asked for than is given: healthy machines had 33 then."""
    windows = "kind: time_proportional, window: 4 s, resolution: 20 ms, pin: D3"
    text = WIDE.replace("kind: digital, pin: D3", windows).replace("200 J/K", "60 J/K")
    text = text.replace("    sense:", "    bears: {air: 250 °C}\n    sense:")
    assert controller_of(text).loops["air"].protection.effort is None
    for asked_for in ("{}", "{for: 10 min}"):
        watched_text = text.replace("      rise", f"      effort: {asked_for}\n      rise")
        effort = controller_of(watched_text).loops["air"].protection.effort
        assert effort is not None
        assert effort.has_band
    steered = text.replace("{kind: on_off, hysteresis: 12 K}", "{kind: pid, kp: 2, ki: 0.1}")
    assert controller_of(steered).loops["air"].protection.effort is not None


def falls_s(effort: Effort, off_c: int) -> int:
    """Return for how long it stands, with too little power from the start, in a room of 35 °C."""
    band, seconds, power, now_c = effort.band, 0, 0.9 * effort.band.at(off_c)[1], float(off_c)
    while power < band.at(now_c)[1] and off_c - now_c <= band.move_k:
        seconds += 1
        power *= math.exp(-1 / band.filter_s)
        now_c = 35 + (off_c - 35) * math.exp(-seconds / SLOW_S)
    return seconds


def healthy(controller: Controller, random: Random, spread: Spread) -> Controller:
    """Draw a machine at a corner of the tolerances, or anywhere within them."""
    at_corner = random.random() < 0.5
    share = controller.simulation.plant.tolerance_percent / 100
    low, high = 1 - share, 1 + share
    both = random.choice((low, high)), random.choice((low, high))

    def factor(part: int) -> float:
        return both[part] if at_corner else random.uniform(low, high)

    power = (random.choice(spread.supply) if at_corner else random.uniform(*spread.supply)) ** 2
    rooms_c = [room_c(controller, each) for each in spread.rooms_c]
    ambient_c = random.choice(rooms_c) if at_corner else random.uniform(*rooms_c)
    return machine(controller, factor, power, ambient_c)


def machine(
    controller: Controller,
    factor: Callable[[int], float],
    power: float,
    ambient_c: float,
    initial_c: float | None = None,
) -> Controller:
    """Return a controller with another machine.

    factor -- asked for each part: of a capacity (0), or of a resistance (1).
    """
    simulation = controller.simulation
    plant, filament = simulation.plant, simulation.plant.filament
    # A power that is so many times as large is a machine of so much smaller parts.
    changed = plant.model_copy(update={
        "initial_c": initial_c,
        "nodes": ReadOnlyDict({name: own * factor(0) / power for name, own in plant.nodes.items()}),
        "links": tuple(
            each.model_copy(
                update={"resistance_k_per_w": each.resistance_k_per_w * factor(1) * power}
            )
            for each in plant.links
        ),
        "radiation": tuple(
            each.model_copy(update={"area_m2": each.area_m2 / factor(1) / power})
            for each in plant.radiation
        ),
        "filament": filament and filament.model_copy(
            update={"heat_j_per_k_mm": filament.heat_j_per_k_mm / power}
        ),
    })  # fmt: skip
    simulated = simulation.model_copy(update={"plant": changed, "ambient_c": ambient_c})
    return controller.model_copy(update={"simulation": simulated})


class Asked(_Runs):
    """Machines of one controller in lanes, whose loops are asked for temperatures."""

    asks: list[tuple[float, str, float]]

    def _advance(self, until_s: float) -> None:
        while self.asks and self.asks[0][0] < until_s:
            at_s, loop, setpoint_c = self.asks.pop(0)
            self._lanes._all.advance(at_s)
            self._lanes._all.ask(loop, setpoint_c)
        super()._advance(until_s)


SHORTEST_STEP_S = 0.05
"""Step of time in the model: a day of shorter ones takes hours. All periods are whole steps:
between two readings there would be one step more by turns."""
SHARES = (0.5, 1.0, 0.2, 0.7, 0.1, 1.0)
"""Setpoints, as shares of the way from the lowest to the highest that the weakest machine holds."""


def asked(controller: Controller, hours: float) -> Iterator[tuple[float, str, float]]:
    each_s = hours * 3600 / len(SHARES)
    for name in controller.loops:
        for place, setpoint_c in enumerate(course_c(controller, name)):
            yield 1.0 + place * each_s, name, setpoint_c


def course_c(controller: Controller, name: str) -> list[float]:
    held = held_c(controller, name)
    return [held[round(share * (len(held) - 1))] for share in SHARES]


def held_c(controller: Controller, name: str) -> list[float]:
    """Return what somebody can ask a loop for, and all machines hold, ascending."""
    heated = heated_loop(controller, name, controller.simulation)
    weak_c = min(WIDEST.rooms_c) + 0.48 * heated.plant.steady_k(heated.full_w)
    return [each for each in setpoints_c(Place(controller, name)) if each <= weak_c]


def lanes_of(
    controller: Controller,
    machines: Sequence[Controller],
    hours: float,
    asks: Sequence[tuple[float, str, float]] = (),
) -> list[Logs]:
    end = events({"for": f"{3600 * hours:.0f} s"})
    with afresh():
        runs = Asked([controller] * len(machines), machines, end, kept=["fault.code"])
        runs.asks = sorted(asks or asked(controller, hours))
        runs.go(None)
        return runs.logs()


EXAMPLES = ("chamber", "hotplate", "press", "oven", "barrel", "extruder")


def watched(number: int) -> tuple[str, Controller]:
    """Return a controller whose effort is watched: examples, then drawn ones."""
    if number < len(EXAMPLES):
        return EXAMPLES[number], example(EXAMPLES[number]).controller
    random = Random(f"effort {SEED} {number}")  # noqa: S311 - machines, not secrets
    return f"drawn {number}", drawn_machine(random, _is_watched).spec.controller


def _is_watched(controller: Controller) -> bool:
    loops = controller.loops.values()
    return (
        controller.simulation is not None
        and (step_s := step_of(controller)) >= SHORTEST_STEP_S
        and not any(round(1000 * each.period_s) % round(1000 * step_s) for each in loops)
        and all(held_c(controller, name) for name in controller.loops)
        and any(each.protection.effort is not None for each in loops)
        and not any(each.protection.on_for_at_most_s for each in loops)  # it ends healthy ones
    )


@pytest.mark.parametrize("number", range(amount("effort_controllers")))
def test_healthy_machines_never_trip(number: int) -> None:
    name, controller = watched(number)
    random = Random(f"{name} {SEED}")  # noqa: S311 - machines, not secrets
    spreads = [(CHECKED, WIDEST)[lane % 2] for lane in range(amount("effort_lanes"))]
    machines = [healthy(controller, random, spread) for spread in spreads]
    found = lanes_of(controller, machines, amount("effort_hours"))
    for lane, (spread, logs) in enumerate(zip(spreads, found, strict=True)):
        for loop, log in logs.items():
            codes = set(log["fault.code"].tolist())
            assert not codes & spread.codes, (name, loop, lane, codes)


def test_a_body_that_is_still_hot_holds_a_lower_setpoint_with_little_power() -> None:
    """It did for longer than rule 34 waited: kilns with the largest parts tripped in health."""
    controller = controller_of("kiln")
    power, ambient_c = max(WIDEST.supply) ** 2, max(WIDEST.rooms_c)
    hot = machine(controller, lambda _: 1.3, power, ambient_c, initial_c=530.0)
    (logs,) = lanes_of(controller, [hot], 1.25, [(1.0, "chamber", 300.0)])
    assert set(logs["chamber"]["fault.code"].tolist()) == {0}


@pytest.mark.parametrize(("highest", "hysteresis"), [("200", "2"), ("250", "3"), ("270", "3")])
def test_a_switched_loop_has_the_rule_wherever_its_last_swing_ends(
    highest: str, hysteresis: str
) -> None:
    changes = ("maximum: 300 °C", f"maximum: {highest} °C"), ("s: 1 K", f"s: {hysteresis} K")
    loop = controller_of(changed("hotplate", *changes)).loops["plate"]
    assert loop.protection.effort is not None


WITH_BINARIES = (*EXAMPLES, "kiln", "fabricator", "feeder", "dryer", "kiln_uno", "printer")


@pytest.mark.parametrize("number", range(amount("effort_binaries")))
def test_nor_do_their_binaries(number: int) -> None:
    """With sensors and interfaces of their own; the first loop is asked for temperatures."""
    name = WITH_BINARIES[number % len(WITH_BINARIES)]
    controller = controller_of(name)
    loop, *_ = controller.loops
    random = Random(f"{name} {number} {SEED}")  # noqa: S311 - machines, not secrets
    drawn = healthy(controller, random, CHECKED).simulation
    ambient_c = drawn.ambient_c
    site = Site(controller, loop, whole(name))
    world = World(site, Weather(ambient_c, ambient_c, drawn.plant))
    first_steps(world)
    for setpoint_c in course_c(controller, loop):
        world.set_setpoint(setpoint_c)
        world.run(amount("effort_hours") * 3600 / len(SHARES))
        assert world.fault == 0, (name, setpoint_c, world.now_s)


def test_healthy_machines_of_this_module_are_at_the_ends() -> None:
    controller = example("chamber").controller
    random = Random(0)  # noqa: S311 - machines, not secrets
    rooms = {healthy(controller, random, WIDEST).simulation.ambient_c for _ in range(40)}
    assert set(WIDEST.rooms_c) <= rooms
