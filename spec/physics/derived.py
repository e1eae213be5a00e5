"""Derives the limits of protections from plant and host, where the spec leaves them out."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from heatwright.spec.algorithms import Lie
from heatwright.spec.base import ReadOnlyDict
from heatwright.spec.loops import Effort, Frozen, Heating, Limits, Loop, RisingWhileOff, Runaway
from heatwright.spec.physics.effort import effort_of
from heatwright.spec.physics.heated_loop import (
    LEAST_TIMES,
    TIMES,
    HeatedLoop,
    heated_loop,
    most_borne,
)
from heatwright.spec.physics.stand import Stand, counted_for_s, times_of
from heatwright.spec.physics.stuck import BELOW_K, Spell, Times, ends_s, fallen, peaks_k
from heatwright.spec.quantity import about, celsius, duration, number

if TYPE_CHECKING:
    from heatwright.spec.controller import Controller
    from heatwright.spec.simulation import Simulation


LOSSES = 1.5
"""Factor by which a machine may need more power than its plant: resistances 30 % smaller, and a
supply that gives 5 % less power."""

WEAK = 0.81
"""Share of its power that a heater has if the supply is 10 % low, which EN 50160 allows."""

BEHIND = 1.5
"""Wanted ratio of `frozen`'s time to `heating`'s: at full power `heating` detects a dead heater as
well as a frozen sensor and trips first; and the duty has time to grow to full power."""

SPREAD = 1.3
"""Factor on the rise by a neighbour's heat, or by stored heat after the heater went off, because a
machine's resistances have a tolerance of 30 %."""

STANDING = ((BELOW_K, 0.0), (BELOW_K, 1.0), (1.0, 1.0))
"""Cases of a stuck reading: how far below its setpoint, K, and the integral at that time as a share
of the holding duty: 0 after a warm start."""

SHORTEST_S, SHORTEST_HEATING_S = 20.0, 5.0
"""Shortest derived times: a draught, or some lost readings, must not cause a trip."""

HOST_LOST_AFTER_S = 600.0
"""Time without a line after which a G-code host is lost: Klipper's `idle_timeout`."""

SMALL_FLASH_BYTES = 16 * 1024
"""Chips with this much flash or less get the rules of `effort` only if the spec names them."""

_LOCKOUT = {"trips": "trips", "within": "within_s"}
"""The lock-out's keys that are derived unless they are given, and their fields."""

_KNOWN: dict[str, dict[str, Limits]] = {}
"""Cache of derived rules by everything they depend on: simulating a plant is slow."""

_EFFORTS: dict[str, Effort | None] = {}
"""Cache of rules 33 and 34 by everything they depend on."""

_OPEN: dict[str, dict[str, str]] = {
    "heating": {"within_s": "within"},
    "frozen": {"for_s": "for", "holding_percent": "holding"},
    "runaway": {"above_k": "above"},
    "rising_while_off": {"rise_k": "rise", "settle_s": "settle"},
}
"""Keys that are derived unless they are given, by rule and field. A later rule needs the numbers
that were derived before it."""


def with_derived(controller: Controller) -> Controller:
    """Derive the numbers that the spec leaves out of a loop's rules."""
    loops = {}
    for name, loop in controller.loops.items():
        limited = _with_limits(controller, name, _with_host_lost(controller, name, loop))
        loops[name] = _with_effort(controller, name, limited)
    if any(loops[name] is not loop for name, loop in controller.loops.items()):
        controller = controller.model_copy(update={"loops": ReadOnlyDict(loops)})
    return _with_lockout(controller)


def _with_lockout(controller: Controller) -> Controller:
    """Derive how many trips the machine withstands, and for how long they must be counted.

    Somebody who ignores the machine acknowledges each trip of a sensor that has fallen out.
    """
    lockout, simulation = controller.lockout, controller.simulation
    if lockout is None or simulation is None:
        return controller
    stands = list(_stands(controller, simulation))
    words = dict.fromkeys(lockout.derived, "as usual")
    given = {"trips": lockout.trips, "within": lockout.within_s}
    usual = {
        key: type(lockout).model_fields[field].default
        for key, field in _LOCKOUT.items()
        if field not in lockout.model_fields_set or key in lockout.derived
    }
    values = given | usual
    for stand, times in stands if "trips" in usual else ():
        borne = stand.trips_borne(times, values["trips"])
        if borne < values["trips"] and (peak := stand.insisted(times, borne + 1)):
            words["trips"] = (
                f"at {borne + 1} trips {peak.node} would reach {about(peak.peak_c)} °C, and it "
                f"withstands {about(peak.bears_c)} °C"
            )
            values["trips"] = borne
    for stand, times in stands if "within" in usual and values["trips"] > 1 else ():
        longer_s = counted_for_s(stand, times, usual["within"])
        if longer_s is not None and longer_s > values["within"]:
            words["within"] = "a trip that comes later finds the machine cool enough"
            values["within"] = longer_s
    if not words:
        return controller
    # Numbers that are not in `words` stay as they are, so that a default does not look given.
    found = {_LOCKOUT[key]: values[key] for key in words}
    lockout = lockout.model_copy(update=found).derived_as(words)
    safety = controller.safety.model_copy(update={"lockout": lockout})
    return controller.model_copy(update={"safety": safety})


def _stands(controller: Controller, simulation: Simulation) -> Iterator[tuple[Stand, Times]]:
    """Yield the steady state and the rules' times of each loop whose plant the checks accept."""
    from heatwright.spec.commands import setpoints_c  # noqa: PLC0415 - it imports the controller

    for name, loop in controller.loops.items():
        try:
            heated = heated_loop(controller, name, simulation)
            yield Stand(loop, heated, setpoints_c(controller, name)), times_of(loop)
        except (ArithmeticError, AssertionError, LookupError, ValueError):
            continue  # the checks report what is wrong with such a plant


def _with_host_lost(controller: Controller, name: str, loop: Loop) -> Loop:
    """Set `master_lost_after` of a loop that a host commands, if the spec leaves it out."""
    hosts = (each for each in controller.interfaces if each.is_host)
    given = "master_lost_after_s" in loop.protection.model_fields_set
    if given or not any(name in host.named_loops.values() for host in hosts):
        return loop
    protection = loop.protection.model_copy(update={"master_lost_after_s": HOST_LOST_AFTER_S})
    return loop.model_copy(update={"protection": protection})


def _with_effort(controller: Controller, name: str, loop: Loop) -> Loop:
    """Add the limits of rules 33 and 34, and the rules themselves where the spec omits them."""
    simulation, given = controller.simulation, loop.protection.effort
    left_out = "effort" not in loop.protection.model_fields_set
    has_room = controller.board.flash_bytes > SMALL_FLASH_BYTES
    if simulation is None or (given is None and not (left_out and has_room)):
        return loop
    others = [(each.heater, each.sensor, each.setpoint) for each in controller.loops.values()]
    derived = given and given.derived
    key = repr((simulation, controller.outputs, controller.sensors, others, loop, derived))
    if key not in _EFFORTS:
        try:
            heated = heated_loop(controller, name, simulation)
            rule = effort_of(controller, name, simulation, heated, given)
        except (ArithmeticError, AssertionError, LookupError, ValueError):
            rule = None  # the checks report what is wrong with such a plant
        # A rule that the spec gives stays, and the checks report that it is not possible.
        _EFFORTS[key] = given if rule is None and given and not given.derived else rule
    if _EFFORTS[key] is given:
        return loop
    protection = loop.protection.model_copy(update={"effort": _EFFORTS[key]})
    return loop.model_copy(update={"protection": protection})


def _with_limits(controller: Controller, name: str, loop: Loop) -> Loop:
    simulation, protection = controller.simulation, loop.protection
    wanted = {name: sorted(_open(getattr(protection, name), name)) for name in _OPEN}
    if simulation is None or not any(wanted.values()):
        return loop
    others = [(each.heater, each.sensor, each.setpoint) for each in controller.loops.values()]
    key = repr((simulation, controller.outputs, controller.sensors, loop, wanted, others))
    if key not in _KNOWN:
        try:
            _KNOWN[key] = _Rules(heated_loop(controller, name, simulation), loop).found()
        except (ArithmeticError, AssertionError, LookupError, ValueError):
            _KNOWN[key] = {}  # the checks report what is wrong with such a plant
    if not _KNOWN[key]:
        return loop
    return loop.model_copy(update={"protection": protection.model_copy(update=_KNOWN[key])})


def _open(rule: Limits | None, name: str) -> set[str]:
    """Return the fields of a rule that are neither given nor off."""
    return {
        field
        for field, key in _OPEN[name].items()
        if rule is not None and (field not in rule.model_fields_set or key in rule.derived)
    }


class _Times(NamedTuple):
    """The basis of a rule's time: the time that a healthy machine needs, s, and its derivation."""

    usual_s: float
    needs_s: float
    words: str
    shortest_s: float
    least_times: float = TIMES
    first: tuple[float, str] = (0.0, "")
    """A time that follows from another rule, s, and its derivation in words."""


class _Rules:
    """The rules of one loop while their numbers are derived."""

    def __init__(self, heated: HeatedLoop, loop: Loop) -> None:
        self._heated, self._loop, self._protection = heated, loop, loop.protection
        self._values: dict[str, dict[str, float]] = {name: {} for name in _OPEN}
        self._words: dict[str, dict[str, str]] = {name: {} for name in _OPEN}
        self._open = {name: _open(getattr(loop.protection, name), name) for name in _OPEN}

    def found(self) -> dict[str, Limits]:
        """Return the rules that have numbers from the plant."""
        if "holding_percent" in self._open["frozen"]:
            self._derive_holding()
        if "within_s" in self._open["heating"]:
            self._derive_within()
        if "for_s" in self._open["frozen"]:
            self._derive_for()
        if "above_k" in self._open["runaway"]:
            self._derive_above()
        if self._open["rising_while_off"]:
            self._derive_rising()
        return {
            name: getattr(self._protection, name)
            .model_copy(update=values)
            .derived_as(self._words[name])
            for name, values in self._values.items()
            if values
        }

    def _put(self, rule: str, field: str, *choices: tuple[float, str]) -> float:
        """Set a rule's number to the largest of the choices, and return it."""
        value, self._words[rule][_OPEN[rule][field]] = max(choices)
        self._values[rule][field] = value
        return value

    def _number(self, rule: str, field: str) -> float:
        """Return a rule's number: derived, otherwise the present one; infinite without the rule."""
        limits = getattr(self._protection, rule)
        return math.inf if limits is None else self._values[rule].get(field, getattr(limits, field))

    def _derive_holding(self) -> None:
        """Find `holding`, the duty up to which a reading may be constant.

        If it is below the duty that this plant needs on a cold day, with a weak supply, a healthy
        machine trips. A higher one suits machines that lose more than their plant. But all nodes
        must withstand it permanently, because no rule detects a frozen reading at this duty, and
        between it and full power there must be a range in which the rule can trip.
        """
        heated = self._heated
        held = f"the duty that holds {celsius(heated.highest_c)} on a cold day"
        weak = f"{held} at a supply that is 10 % low"
        needed_w = min(heated.most_hold_w(), (heated.hold_w + heated.full_w) / 2)
        half_w, weak_w = (needed_w + heated.full_w) / 2, needed_w / WEAK
        choices = [
            (LOSSES * needed_w, f"{number(LOSSES)} times {held}"),
            max((heated.borne_w(), "the duty that all nodes withstand"), (weak_w, weak)),
            (half_w, f"half way from {held} to full power"),
        ]
        least_w, words = min(choices)
        if least_w < weak_w < heated.full_w:
            least_w, words = weak_w, weak
        percent = math.ceil(1000 * least_w / heated.power_w) / 10
        self._put("frozen", "holding_percent", (percent, words))

    def _derive_within(self) -> None:
        """Find how long full power may last: enough for a rise, and no node becomes too hot."""
        heated = self._heated
        rise_k = self._number("heating", "rise_k")
        needs_s = heated.slowest_rise(rise_k)[0]
        self._put_time(
            "heating",
            "within_s",
            _Times(
                float(Heating.model_fields["within_s"].default),
                needs_s,
                f"the slowest rise of {number(rise_k)} K takes {about(needs_s)} s at full power",
                SHORTEST_HEATING_S,
                LEAST_TIMES,
            ),
            self._is_borne_within,
            "all nodes withstand full power for this time",
        )

    def _derive_for(self) -> None:
        """Find how long the duty may be above `holding` without a change of the reading.

        It is the default of specs without a plant, so that a machine that loses more heat does not
        trip in its steady state; at most the time that nodes withstand, but at least the time that
        a healthy machine needs.
        """
        within_s, still_s = self._number("heating", "within_s"), self._still_s
        if still_s is None:
            return
        first = (0.0, "")
        if within_s < math.inf:
            words = f"{number(BEHIND)} times heating.within, so that heating_failed trips first"
            first = (BEHIND * within_s, words)
        self._put_time(
            "frozen",
            "for_s",
            _Times(
                float(Frozen.model_fields["for_s"].default),
                still_s,
                f"at that duty a healthy reading is constant for up to {about(still_s)} s",
                SHORTEST_S,
                first=first,
            ),
            lambda each: self._is_borne_still(within_s, each),
            "all nodes withstand the duty for this time",
        )

    def _put_time(
        self, rule: str, field: str, times: _Times, borne: Callable[[float], bool], why: str
    ) -> None:
        """Set the usual time or the one that a healthy machine needs, limited by the nodes.

        borne -- whether all nodes withstand a time; why -- the words for a time that this limits.
        """
        heated, late = self._heated, f", and {_seconds(self._heated.late_s)} for delays"
        wished_s, words = max(
            (times.usual_s, "as usual"),
            times.first,
            (
                TIMES * times.needs_s + heated.late_s,
                f"{times.words}; {number(TIMES)} times that{late}",
            ),
        )
        borne_s = wished_s if borne(wished_s) else most_borne(borne, 0.0, wished_s)
        least_s = times.least_times * times.needs_s + heated.late_s
        if borne_s == wished_s:
            chosen = heated.rounded_s(wished_s, times.shortest_s), words
        elif borne_s >= least_s:
            chosen = heated.rounded_down_s(borne_s, times.shortest_s), why
        else:
            words = f"{times.words}; {number(times.least_times)} times that{late}"
            chosen = heated.rounded_s(least_s, times.shortest_s), words
        self._put(rule, field, chosen)

    @cached_property
    def _still_s(self) -> float | None:
        """How long a healthy reading may be constant at the duty that holding may need, s.

        None if that duty does not even hold the highest setpoint.
        """
        heated, percent = self._heated, self._number("frozen", "holding_percent")
        power_w = min(heated.power_w * percent / 100, heated.full_w)
        return heated.longest_still_s(power_w) if power_w > heated.hold_w else None

    def _derive_above(self) -> None:
        """Find how far above its setpoint a healthy loop may come."""
        heated, usual_k = self._heated, float(Runaway.model_fields["above_k"].default)
        warmed_k = heated.warmed_k + heated.ambient_c - heated.lowest_c
        self._put(
            "runaway",
            "above_k",
            (usual_k, "as usual"),
            (
                _rounded_up_k(SPREAD * warmed_k),
                f"the other loops warm it by up to {about(warmed_k)} K above its lowest "
                f"setpoint; {number(SPREAD)} times that",
            ),
            (
                _rounded_up_k(LOSSES * heated.overshoot_k),
                f"after full power it coasts up by {about(heated.overshoot_k)} K; "
                f"{number(LOSSES)} times that",
            ),
        )

    def _derive_rising(self) -> None:
        """Find how far, and from when on, the reading may rise with its heater off."""
        heated, limits = self._heated, RisingWhileOff.model_fields
        rise_k = self._number("rising_while_off", "rise_k")
        if "rise_k" in self._open["rising_while_off"]:
            usual_k = float(limits["rise_k"].default)
            warmed_k = heated.warmed_k
            rise_k = self._put(
                "rising_while_off",
                "rise_k",
                (usual_k, "as usual"),
                (
                    _rounded_up_k(SPREAD * warmed_k),
                    f"the other loops warm it by up to {about(warmed_k)} K; "
                    f"{number(SPREAD)} times that",
                ),
            )
        if "settle_s" in self._open["rising_while_off"]:
            usual_s = float(limits["settle_s"].default)
            settles_s = heated.settles_s(rise_k / LOSSES)
            self._put(
                "rising_while_off",
                "settle_s",
                (usual_s, "as usual"),
                (
                    heated.rounded_s(TIMES * settles_s, 0.0),
                    f"it coasts up for {about(settles_s)} s; {number(TIMES)} times that",
                ),
            )

    def _is_borne_still(self, within_s: float, for_s: float) -> bool:
        """Return whether nodes withstand the heat after a reading froze in the steady state."""
        heated = self._heated
        held_percent = 100 * heated.hold_w / heated.power_w
        lies = [
            self._loop.algorithm.stuck(below_k, share * held_percent) for below_k, share in STANDING
        ]
        return all(self._is_borne(lie, within_s, for_s) for lie in lies)

    def _is_borne_within(self, within_s: float) -> bool:
        """Return whether nodes withstand full power for a time, with the `frozen` that follows."""
        for_s = self._number("frozen", "for_s")
        if "for_s" in self._open["frozen"] and self._still_s is not None:
            for_s = max(BEHIND * within_s, TIMES * self._still_s + self._heated.late_s)
        lie = fallen(self._loop.algorithm)
        return self._is_borne(lie, within_s, math.inf) and self._is_borne_still(within_s, for_s)

    def _is_borne(self, lie: Lie, within_s: float, for_s: float) -> bool:
        """Return whether all nodes withstand the heat until a rule trips, on a warm day."""
        heated = self._heated
        plant, bears_k = heated.warm
        holding_percent = self._number("frozen", "holding_percent")
        time_s = ends_s(self._loop, lie, Times(within_s, for_s, holding_percent))
        peaks = peaks_k(heated, plant, heated.warm_rest, [Spell(lie, time_s)])
        return all(peak <= most for peak, most in zip(peaks, bears_k, strict=True))


def _rounded_up_k(kelvins: float) -> float:
    """Round a difference up to two digits."""
    if kelvins <= 0:
        return 0.0
    unit = 10.0 ** (math.floor(math.log10(kelvins)) - 1)
    return math.ceil(kelvins / unit - 1e-9) * unit


def _seconds(seconds: float) -> str:
    return duration(round(seconds, 3))
