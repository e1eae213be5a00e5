"""Runs of the reference model on healthy machines, before there is a binary: no rule may trip."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from pydantic import BaseModel

from heatwright.sim.bench import STEP_S, ReferenceDevice, bench
from heatwright.sim.coupling import Coupling, metered_step_s, sums_noise
from heatwright.sim.faults.healthy import Healthy, machines, take_through
from heatwright.sim.faults.site import OfState, Place
from heatwright.sim.plants import plant_of, profile_c
from heatwright.sim.plots.plot_data import faults
from heatwright.sim.reference.numbers import steps
from heatwright.sim.scenario import long_enough, unasked
from heatwright.spec import RULES, Controller, Loop, ThermalNetwork, facts_of
from heatwright.spec.adjusted import Setting, extremes, with_setting, words
from heatwright.spec.board.timers import TICK_S
from heatwright.spec.checks import check
from heatwright.spec.checks.finding import Finding
from heatwright.spec.problems import Path
from heatwright.spec.quantity import duration, rounded_up

Progress = Callable[[float, float], None]

FACTORS = (1.25, 1.6, 2.0, 2.5, 3.2, 4.0, 5.0, 7.0, 10.0)
"""Factors by which a rule's number is raised until a healthy machine no longer trips the rule."""

MARGIN = 0.1
"""Margin of a healthy machine from a rule's limits, as a share of them. The phases between loops
differ between model and binary, so a machine just inside a limit in the model may be outside it in
the binary."""
NO_MARGIN = "on_too_long"
"""The rule without a margin: how long a loop may be on does not depend on phases."""

QUICKER = 0.98
"""A chip's conversion time divided by the longest of the data sheet: if conversions were
synchronous with the loop, the largest differences of two readings would not occur."""

REPORTED = ("time_s", "temperature_c", "setpoint_c")
"""The members of the tripping step that are reported."""


FAN_SHARES = 20
"""A fan's share of a time step is rounded to a multiple of one part in this many."""


class Number(NamedTuple):
    """A number of a rule that can be raised.

    part -- the part of `protection` that contains it, "": `protection` itself; field, key -- its
    name in the Python model, and in the spec.
    """

    part: str
    field: str
    key: str
    unit: str

    def path(self, loop: str) -> Path:
        """Return the number's path in a spec."""
        part = (self.part,) if self.part else ()
        return ("loops", loop, "protection", *part, self.key)


_FOR = Number("runaway", "for_s", "for", "s")
_BELOW = Number("runaway", "below_k", "below", "K")
NUMBERS = {
    "rise_rate": (Number("", "rise_rate_k_per_s", "rise_rate", "K/s"),),
    "sensor_frozen": (Number("frozen", "for_s", "for", "s"),),
    "heating_failed": (Number("heating", "within_s", "within", "s"),),
    "runaway_above": (Number("runaway", "above_k", "above", "K"), _FOR),
    "runaway_below": (_BELOW, _FOR),
    "rising_while_off": (
        Number("rising_while_off", "rise_k", "rise", "K"),
        Number("rising_while_off", "settle_s", "settle", "s"),
    ),
    "sensors_disagree": (
        Number("agreement", "within_k", "within", "K"),
        Number("agreement", "for_s", "for", "s"),
    ),
    "on_too_long": (Number("", "on_for_at_most_s", "on_for_at_most", "s"),),
    "effort_high": (Number("effort", "for_s", "for", "s"),),
    "effort_low": (Number("effort", "for_s", "for", "s"),),
}
"""Numbers to raise, by the rule's id; numbers of other rules depend on machine and sensor."""


class Part(NamedTuple):
    """One rehearsal: of a loop (None: of the scenario), with numbers of the keypad."""

    loop: str | None
    setting: Setting = ()

    def __str__(self) -> str:
        """Describe the part in a few words."""
        if self.loop is None:
            return "the scenario"
        return f"{self.loop} with {words(self.setting)}" if self.setting else self.loop


class Tripped(NamedTuple):
    """A rule that tripped on a healthy machine.

    loop, rule -- the loop and the rule's id; part -- the loop that was taken through its setpoints,
    None: the scenario; machine -- the healthy machine, None: the spec's plant; setting -- the
    numbers that the keypad had set; time_s, reading_c, setpoint_c -- the loop's values at the trip.
    """

    loop: str
    rule: str
    part: str | None
    machine: Healthy | None
    setting: Setting
    time_s: float
    reading_c: float
    setpoint_c: float


class _TrippedError(Exception):
    """Ends a run at a trip: the rest of the run is not needed."""


def parts(controller: Controller) -> tuple[Part, ...]:
    """Return the rehearsals: the scenario, each loop, and the numbers that the keypad can set.

    Without a simulated machine there are none.
    """
    if controller.simulation is None:
        return ()
    keypad = facts_of(controller).keypad
    keyed = () if keypad is None else (Part(keypad.loop, each) for each in extremes(controller))
    return (Part(None), *map(Part, controller.loops), *keyed)


def rehearse(controller: Controller, part: Part, progress: Progress) -> tuple[Tripped, ...]:
    """Run one part, and return the rules that trip; a loop is taken through its setpoints.

    Each healthy machine of `verify` is tried, with rules that are stricter by MARGIN.
    """
    if part.loop is None:
        found = _of_scenario(controller, progress)
        return () if found is None else (found,)
    place = Place(with_setting(controller, part.setting), part.loop)
    tried = list(machines(place))
    tripped = []
    for number, machine in enumerate(tried):
        tripped.append(_of_machine(place, machine, part.setting))
        progress(number + 1, len(tried))
    return tuple(each for each in tripped if each is not None)


def findings(controller: Controller, tripped: Iterable[Tripped]) -> tuple[Finding, ...]:
    """Return one finding per rule that trips, with the number that is enough for all rehearsals.

    A trip ends its run. With that number the run goes on, and the next trip is reported as well.
    """
    found: dict[tuple[str, str], Finding] = {}
    waiting, no_number = list(tripped), set()
    while waiting:
        rule = waiting[0][:2]
        own = [each for each in waiting if each[:2] == rule]
        found[rule], enough = _finding(controller, own)
        waiting = [each for each in waiting if each[:2] != rule]
        if enough is None:
            no_number.add(rule)
        else:
            controller = enough.controller
            waiting += [each for each in enough.tripped if each[:2] not in no_number]
    return tuple(found.values())


def _of_scenario(controller: Controller, progress: Progress | None = None) -> Tripped | None:
    for strict in all_stricter(controller):
        found = _run_scenario(strict, progress)
        if found is not None:
            return found
    return None


def _run_scenario(controller: Controller, progress: Progress | None) -> Tripped | None:
    longer, device = long_enough(controller), ReferenceDevice(controller)
    trace = bench(longer, device, progress=progress)
    for loop, log in trace.steps.items():
        for time_s, code in unasked(longer.simulated, faults(log)):
            if loop == device.fault_loop:
                row = log[np.searchsorted(log["time_s"], time_s)]
                values = (float(row[name]) for name in REPORTED)
                return Tripped(loop, RULES[code].id, None, None, (), *values)
    return None


def _of_machine(place: Place, machine: Healthy, setting: Setting) -> Tripped | None:
    for strict in all_stricter(place.controller):
        world = _World(Place(strict, place.loop_name), machine)
        try:
            take_through(world, machine.setpoints_c)
        except _TrippedError:
            return world.tripped()._replace(setting=setting)
    return None


def _finding(controller: Controller, tripped: Sequence[Tripped]) -> tuple[Finding, _Enough | None]:
    first = tripped[0]
    numbers = NUMBERS.get(first.rule, ())
    path = numbers[0].path(first.loop) if numbers else _path(first)
    where = "in the scenario, although nothing is broken"
    if first.machine is not None:
        where = f"on a healthy machine ({first.machine.what})"
    if first.part not in {first.loop, None}:
        where += f", while {first.part} is taken through its setpoints"
    if first.setting:
        where += f", with {words(first.setting)}, as keys may set it"
    has_margin = numbers and first.rule != NO_MARGIN
    trips = f"trips, or keeps less than {100 * MARGIN:.0f} % margin," if has_margin else "trips"
    reason = (
        f"{first.rule} {trips} {where}: {duration(round(first.time_s, 1))} after the start, at "
        f"{first.reading_c:.1f} °C with a setpoint of {first.setpoint_c:.1f} °C"
    )
    for number in numbers:
        enough = _enough(controller, number, tripped)
        if enough is not None:
            remedy = f"Write {number.key}: {enough.value} {number.unit}"
            return Finding(number.path(first.loop), reason, remedy), enough
    remedy = (
        "Use other gains (`heatwright tune` finds some), a lower setpoint.maximum or less power"
    )
    return Finding(path, reason, remedy), None


def _path(tripped: Tripped) -> Path:
    key = {"over_temperature": "maximum", "under_temperature": "minimum"}.get(tripped.rule)
    loop = ("loops", tripped.loop)
    return (*loop, "protection", key) if key else loop


class _Enough(NamedTuple):
    """A number that is enough, the controller with it, and the rules that trip next."""

    value: str
    controller: Controller
    tripped: tuple[Tripped, ...]


def _enough(controller: Controller, number: Number, tripped: Sequence[Tripped]) -> _Enough | None:
    """Return the smallest raised number with which no run trips the rule; None: there is none."""
    hardest_first = list(tripped)
    for factor in FACTORS:
        value, other = _raised(controller, tripped[0].loop, number, factor)
        if check(other):
            return None  # another rule, or a node's limit (`bears`), forbids it
        next_ones = []
        for each in hardest_first:
            again = _once_more(other, each)
            if again is not None and again[:2] == each[:2]:
                hardest_first.remove(each)
                hardest_first.insert(0, each)
                break
            next_ones.append(again)
        else:
            return _Enough(value, other, tuple(each for each in next_ones if each is not None))
    return None


def _once_more(controller: Controller, tripped: Tripped) -> Tripped | None:
    """Repeat the run of a trip with other numbers, and return the next trip."""
    if tripped.part is None or tripped.machine is None:
        return _of_scenario(controller)
    place = Place(with_setting(controller, tripped.setting), tripped.part)
    return _of_machine(place, tripped.machine, tripped.setting)


def all_stricter(controller: Controller) -> Iterator[Controller]:
    """Yield the controller with stricter rules, and again with each `below` as it is.

    A smaller `below` is not stricter everywhere: a machine that swings far below its setpoint while
    it warms up may never reach the smaller band, but reach and leave the larger one.
    """
    yield stricter(controller)
    if any(_value(loop, _BELOW) is not None for loop in controller.loops.values()):
        yield stricter(controller, _BELOW)


def stricter(controller: Controller, kept: Number | None = None) -> Controller:
    """Return the controller with stricter rules: their numbers but one are reduced by MARGIN."""
    numbers = {each for rule in NUMBERS if rule != NO_MARGIN for each in NUMBERS[rule]} - {kept}
    for name, loop in controller.loops.items():
        for number in numbers:
            value = _value(loop, number)
            if value is not None:
                controller = _with(controller, name, number, _less(value, number, loop))
    return controller


def _less(value: float, number: Number, loop: Loop) -> float:
    """Reduce a limit by MARGIN, and by at least one period if it counts periods, if possible."""
    periods = steps(value, loop)
    if number.unit != "s" or periods == 1:
        return (1 - MARGIN) * value
    return loop.periods_s(min(periods - 1, math.floor((1 - MARGIN) * periods)))


def _raised(
    controller: Controller, name: str, number: Number, factor: float
) -> tuple[str, Controller]:
    """Raise a number; return it as in a spec, and the controller with it."""
    before = _value(controller.loops[name], number)
    assert before is not None  # noqa: S101 - its rule has tripped
    value = rounded_up(factor * before)
    return value, _with(controller, name, number, float(value))


def _holder(loop: Loop, number: Number) -> BaseModel | None:
    return getattr(loop.protection, number.part) if number.part else loop.protection


def _value(loop: Loop, number: Number) -> float | None:
    """Return a rule's number; None if the loop has no such rule."""
    holder = _holder(loop, number)
    return None if holder is None else getattr(holder, number.field)


def _with(controller: Controller, name: str, number: Number, value: float) -> Controller:
    loop = controller.loops[name]
    holder = _holder(loop, number)
    assert holder is not None  # noqa: S101 - `_value` has found it
    protection = holder.model_copy(update={number.field: value})
    if number.part:
        protection = loop.protection.model_copy(update={number.part: protection})
    return controller.with_loop(name, loop.model_copy(update={"protection": protection}))


def _summed_k(controller: Controller, network: ThermalNetwork) -> dict[str, float]:
    """Return the noise of each single code of sensors whose codes the ADC sums, K."""
    return {
        name: each.noise_k for name, each in network.sense.items() if sums_noise(controller, name)
    }


def _step_s(controller: Controller) -> float:
    """Return the time step, s.

    It is at most a tenth of a period in which a current is measured, unless all periods are whole
    multiples of the usual step: the duty is then constant in the step before a reading.
    """
    step_s = min(STEP_S, controller.shortest_period_s)
    if not any(loop.period_ticks % round(step_s / TICK_S) for loop in controller.loops.values()):
        return step_s
    return min(step_s, metered_step_s(controller))


class _World:
    """The reference model on a machine, with an operator who sets its setpoints."""

    def __init__(self, place: Place, machine: Healthy) -> None:
        controller = place.controller
        self.site = place
        self.step_s = _step_s(controller)
        self._machine = machine
        noise_k = _summed_k(controller, machine.network)
        sense = {
            name: each.model_copy(update={"noise_k": 0.0}) if name in noise_k else each
            for name, each in machine.network.sense.items()
        }
        self._device = ReferenceDevice(controller, noise_k, most_rows=1, feels=self)
        self._plant = plant_of(
            controller,
            machine.network.model_copy(update={"initial_c": machine.ambient_c, "sense": sense}),
            ambient_c=machine.ambient_c,
            step_s=self.step_s,
            starts_c=profile_c(
                controller, machine.network, place.loop_name, machine.start_c,
                ambient_c=machine.ambient_c,
            ),
        )  # fmt: skip
        self._fans = tuple(machine.network.fans)
        loads = (*machine.network.heat, *self._fans)
        self._coupling = Coupling(controller, self._device, self.step_s, loads)
        self._row = 0
        self._chips_s = {
            name: QUICKER * sensor.free_running_s
            for name, sensor in controller.thermometers.items()
            if sensor.free_running_s
        }
        steps = math.ceil(max(self._chips_s.values(), default=0.0) / self.step_s)
        self._currents = frozenset(self._plant.currents_a())
        self._felt = deque([self._plant.sensed_c() | self._plant.currents_a()], steps + 2)

    def step(self) -> None:
        """Advance by one step of time; raises _TrippedError when a fault is latched.

        Sensors follow the machine one step late, interpolated linearly, as periods need not be
        whole steps. A chip that converts continuously samples at the start of a conversion.
        """
        felt = self._plant.sensed_c()
        if self._currents:
            felt |= self._plant.currents_a()
        self._felt.append(felt)
        self._row += 1
        self._device.advance(self._row * self.step_s)
        given = self._coupling.active()  # the model's relay is closed whenever a heater is on
        if self._fans:  # each share of a fan needs its own matrix
            shares = {fan: round(given[fan] * FAN_SHARES) / FAN_SHARES for fan in self._fans}
            given = {**given, **shares}
        self._plant.step(given, self._coupling.feed_mm_per_s())
        if self._device.fault:
            raise _TrippedError

    def __getitem__(self, sensor: str) -> float:
        """Return a sensor's present temperature, °C, or its current in the last step, A."""
        if sensor in self._currents:
            return self._felt[-1][sensor]
        time_s, every_s = self._device.now_s, self._chips_s.get(sensor)
        if every_s is not None:
            time_s = time_s // every_s * every_s
        place = max(0.0, time_s / self.step_s - self._row + len(self._felt) - 1)
        row = min(int(place), len(self._felt) - 2)
        before, after = self._felt[row][sensor], self._felt[row + 1][sensor]
        return before + (place - row) * (after - before)

    def run(self, seconds: float) -> None:
        """Run for a time, in whole steps."""
        for _ in range(round(seconds / self.step_s)):
            self.step()

    def until(self, condition: OfState, within_s: float) -> bool:
        """Run until a condition holds; return False if that takes longer."""
        for _ in range(round(within_s / self.step_s)):
            if condition(self):
                return True
            self.step()
        return condition(self)

    @property
    def fault(self) -> int:
        """The latched fault, 0 for none."""
        return self._device.fault

    def set_setpoint(self, setpoint_c: float) -> None:
        """Set the loop's setpoint, °C."""
        self._device.ask(self.site.loop_name, setpoint_c)

    def switch_off(self) -> None:
        """Switch the loop off."""
        self._device.switch_off(self.site.loop_name)

    def loop(self, member: str) -> float:
        """Return a member of the loop's state after its last step."""
        return self._device.last(self.site.loop_name, member)

    def tripped(self) -> Tripped:
        """Describe the trip."""
        device = self._device
        values = (device.last(device.fault_loop, name) for name in REPORTED)
        rule = RULES[device.fault].id
        return Tripped(device.fault_loop, rule, self.site.loop_name, self._machine, (), *values)
