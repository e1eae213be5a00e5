"""The trial of a fault: cause, trip, acknowledgement, cure, loss of power, acknowledgement.

The reference model gets the firmware's readings, and says which fault must be latched, and when
(heatwright.sim.faults.witness). A healthy machine is watched for a while: no rule may trip.
On any other machine, if a rule trips, its fault must

1. be latched in the step in which its condition is met, with the heater off;
2. be shown with its number and words on the display, and be sent to the host;
3. stay latched after the cause is removed, and through a loss of power;
4. be cleared by an acknowledgement after that.

Many faults are also acknowledged earlier, while the cause lasts: the rules then decide whether one
trips again. One fault is acknowledged repeatedly, until the lock-out needs a person at the machine.
From each trip to its acknowledgement no heater's pin may be on for a single cycle. No node of the
machine may become hotter than its limit (`bears`), until the heat has spread after the first trip,
or after the last repeated trip.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from heatwright.sim.faults import witness
from heatwright.sim.faults.bounds import TICK_S, start_up_s
from heatwright.sim.faults.fault import Fault, FaultResult, Trip, at_once
from heatwright.sim.faults.machine import longest_rule_s
from heatwright.sim.faults.machine_parts import coolers, relays
from heatwright.sim.faults.operation import notices
from heatwright.sim.faults.operation.left_on import TOO_LONG
from heatwright.sim.faults.peaks import SPREADING_S
from heatwright.sim.faults.records import Change
from heatwright.sim.faults.sensing.readings import CURRENT_RULES, LACKS_HEAT, SENSOR_RULES
from heatwright.sim.faults.site import LATCHED
from heatwright.sim.faults.starts import highest_c
from heatwright.sim.faults.world import SPREAD, World, below
from heatwright.sim.judges.interlock import overlaps
from heatwright.spec import RULES, Frozen, Heating, Protection
from heatwright.spec.checks import check
from heatwright.spec.controller import Lockout

LATE_S = 5.0
"""How much longer than the bound to wait, to distinguish a late trip from none."""
REST_S = 2.0
"""How long a latched fault is watched: longer than the display's two lines take (one cell a tick,
after at most ten ticks of start-up) and a record in the EEPROM (one byte a tick)."""

INSISTED_S = 1800.0
"""How long acknowledgements are repeated at least, if the lock-out does not refuse them before."""
REFUSED_S = 30.0

SHOWN_S = 0.1
"""Much longer than the gate takes to switch a heater off."""

STILL_K = 1.0
"""A machine that would move by less in the rest of its time stands still."""

COOLER_K = 5.0
COOLING_S = 4 * 3600.0


def try_fault(fault: Fault) -> FaultResult:
    """Try a fault in its own world."""
    trial = _Trial(fault, fault.make())
    trial.run()
    return trial.result()


@dataclass
class _Trial:
    """The trial of one fault, and its state so far.

    first -- the first trip, which is reported; cause_s -- time of the cause.
    """

    fault: Fault
    world: World
    problems: list[str] = field(default_factory=list)
    first: Change | None = None
    counting: tuple[str, ...] = ()
    cause_s: float = 0.0
    off_s: float | None = None
    peak_c: float = 0.0

    def run(self) -> None:
        if self.world.fault and not self.fault.may:
            self._wrong(f"{_name(self.world.fault)} was latched before the trial began")
            return
        self._begin()
        if self.fault.calm:
            self._may_not_trip()
        else:
            self._may_trip()
        self._end()

    def _begin(self) -> None:
        self.cause_s = self.world.now_s
        self.world.watch_peaks()
        self.fault.cause(self.world)

    def _end(self) -> None:
        judged = self.fault.judge(self.world)
        self.world.device.feed()
        own = (self.world.site.loop_name,) if self.fault.sensor_lies else ()
        lying = (*own, *self.fault.others_lie)
        said = witness.complaints(self.world, lying, current_lies=self.fault.current_lies)
        for complaint in (judged, *overlaps(self.world.device.interlocks), *said):
            if complaint:
                self._wrong(complaint)

    def result(self) -> FaultResult:
        first, trip = self.first, self.fault.trip
        return FaultResult(
            fault=self.fault.id,
            loop=self.world.site.loop_name,
            calm=self.fault.calm,
            rule=RULES[first.code].id if first else None,
            counting=self.counting,
            tripped_after_s=first.time_s - self.cause_s if first else None,
            allowed_s=trip.allowed_s if trip else None,
            heater_off_after_s=self.off_s,
            peak_c=self.peak_c,
            problems=tuple(self.problems),
        )

    def _wrong(self, text: str) -> None:
        self.problems.append(text)

    # -- nothing may trip ----------------------------------------------------------------------

    def _may_not_trip(self) -> None:
        self.world.run(self.fault.watch_s)
        self._judge_peaks()
        trips = self.world.trips.since(self.cause_s)
        trips = [trip for trip in trips if RULES[trip.code].id not in self.fault.may]
        if trips:
            self.first = trips[0]
            self._wrong(f"{_name(trips[0].code)} tripped for no reason")

    # -- a rule trips, if its condition is met ---------------------------------------------------

    def _may_trip(self) -> None:
        self.first = self._wait(self.cause_s, "")
        self.counting = witness.counting(self.world)
        self._judge_heater()
        if self.first is None or not self.fault.insisted:
            self._judge_peaks()  # not later: a switch that has failed closed continues to heat
        if self.first is None:
            return
        self._holds(self.first, "after the trip")
        latched: Change | None = self.first
        can = self.world.site.controller.is_acknowledged and not self.world.is_locked_out
        if self.fault.again and can:
            latched = self._again()
        if self.fault.insisted:
            latched = self._insisted()
        if latched is None:
            latched = self._repeated()
        if latched is not None:
            self._cured(latched)

    def _cured(self, latched: Change) -> None:
        """Remove the cause, and check that the fault stays latched until it is acknowledged."""
        self.fault.cure(self.world)
        self._cools_down()
        self._holds(latched, "after its cause was removed")
        self.world.power_cut()
        self._holds(latched, "after a loss of power")
        self._clears()

    def _repeated(self) -> Change | None:
        """Repeat the trial up to the trip, in a new world."""
        self._end()
        self.world = self.fault.make()
        self._begin()
        latched = self._wait(self.cause_s, " in the second trial")
        if latched is not None:
            self._holds(latched, "after the trip in the second trial")
        return latched

    def _cools_down(self) -> None:
        """Wait until the machine is well below its maximum, which would rightly trip again.

        It must also be within its setpoints: above them, one step of an analog sensor may be
        large enough to count as a jump. And the tip must move slowly enough for `rise_rate`.
        """
        loop = self.world.site.loop
        limit_c = min(loop.protection.maximum_c - COOLER_K, loop.setpoint.maximum_c)
        self.world.until(below(limit_c), COOLING_S)
        self._moves_slowly()

    def _wait(self, began_s: float, when: str) -> Change | None:
        """Wait until a fault is latched; return None if no rule has tripped, which may be right."""
        trip = self.fault.trip
        if trip is None:
            self._watch()
            return self._recorded(began_s)
        since_s = self._follow(trip, began_s)
        if since_s is None:
            if trip.certain:
                self._wrong(f"its trip condition was not met within {trip.due_within_s:g} s{when}")
            return None
        found = self._recorded(began_s)
        if found is None:
            self._wrong(f"nothing tripped{when}")
        else:
            self._judge_trip(trip, found, since_s, when)
        return found

    def _watch(self) -> None:
        """Run until a fault is latched, for at most the fault's time.

        After the first trip, a machine that stands still is watched no longer than its rules take.
        """
        world, left_s = self.world, self.fault.watch_s
        span_s = left_s if self.first is None else longest_rule_s(world.site) + LATE_S
        while left_s > 0:
            before_c = np.array([world.sensed_c, world.tip_c])
            if world.until(LATCHED, min(span_s, left_s)):
                return
            left_s -= span_s
            moved_k = np.abs([world.sensed_c, world.tip_c] - before_c).max()
            if moved_k * left_s < STILL_K * span_s:
                return

    def _recorded(self, began_s: float) -> Change | None:
        """Return the first trip since `began_s`; it is recorded when the program next sleeps.

        After a reset this takes a whole start-up, during which the RAM is not valid.
        """
        if self.world.fault:
            within_s = max(start_up_s(self.world.site), self.world.step_s)
            self.world.until(lambda now: bool(now.trips.since(began_s)), within_s)
        return next(iter(self.world.trips.since(began_s)), None)

    def _follow(self, trip: Trip, began_s: float) -> float | None:
        """Run until a fault is latched, or until a trip would be much too late.

        Return the time since which the condition has been met without a gap, from the beginning of
        that step of time. If the trip comes before the condition, return the step before the trip.
        """
        world = self.world
        if trip.due is at_once:  # in one run, for speed: a long stale_after may be days
            from_s = max(began_s, world.now_s - world.step_s)
            world.until(LATCHED, from_s + trip.allowed_s + LATE_S + world.step_s - world.now_s)
            return from_s
        since_s: float | None = None
        give_up_s = began_s + trip.due_within_s
        while not LATCHED(world):
            if not trip.due(world):
                since_s = None
            elif since_s is None:
                since_s = max(began_s, world.now_s - world.step_s)
            late_s = give_up_s if since_s is None else since_s + trip.allowed_s + LATE_S
            if world.now_s > late_s:
                return since_s
            world.step()
        return max(began_s, world.now_s - world.step_s) if since_s is None else since_s

    def _judge_trip(self, trip: Trip, found: Change, since_s: float, when: str) -> None:
        if trip.rules and RULES[found.code].id not in (*trip.rules, *self._may_come_first()):
            self._wrong(f"{_name(found.code)} tripped, not {' or '.join(trip.rules)}{when}")
        after_s = found.time_s - since_s
        if after_s > trip.allowed_s:
            self._wrong(f"tripped after {after_s:.3f} s, not within {trip.allowed_s:.3f} s{when}")

    def _may_come_first(self) -> tuple[str, ...]:
        """Return the rules that may trip before the expected one.

        Without readings there is no heat. A current that is no longer read seems to flow while the
        heater is off. The time `on_for_at_most` may end earlier, too.
        """
        limited = self.world.site.loop.protection.on_for_at_most_s is not None
        silent = self.fault.sensor_lies and self.fault.current_lies
        lies = (*(CURRENT_RULES if silent else ()), *((TOO_LONG,) if limited else ()))
        log = self.world.device.steps(self.world.site.loop_name)
        read = len(log) and log[-1]["has_reading"] and not log[-1]["reading_status"]
        return lies if read else (*lies, *LACKS_HEAT)

    def _judge_heater(self) -> None:
        """Check how soon the heater was off, and let the heat spread."""
        limit_s = self.fault.off_within_s
        self.world.run(SHOWN_S)
        if self.first is None and limit_s is None:
            return
        others_go_on = limit_s is not None and not self.fault.all_off
        log = self.world.heater if others_go_on else self.world.heaters
        last_on_s = log.last_on_s(self.cause_s)
        self.off_s = 0.0 if last_on_s is None else last_on_s - self.cause_s
        if limit_s is not None and self.off_s > limit_s:
            self._wrong(f"heater off after {self.off_s:.3f} s, not within {limit_s:.3f} s")
        if not self.fault.insisted:  # repeated acknowledgements do not wait for this
            self.world.until(SPREAD, SPREADING_S)

    def _judge_peaks(self) -> None:
        """Check that no node became hotter than its limit; report only the first one."""
        self.peak_c = max(self.peak_c, self.world.peak_c)
        self.world.peaks.end()
        borne_c = self.world.bears_c
        for node, peak_c in self.world.peaks.highest_c.items():
            bears_c = borne_c[node]
            if peak_c > bears_c:
                self._wrong(
                    f"{node} reached {peak_c:.1f} °C but its limit is {bears_c:.1f} °C. If it "
                    f"withstands that, write simulation.plant.bears: {{{node}: {math.ceil(peak_c)} "
                    f"°C}}. Otherwise {self._remedy(node, bears_c)}"
                )
                return

    def _remedy(self, node: str, bears_c: float) -> str:
        """Return advice: the value of a key that would have kept a node from becoming too hot."""
        lockout = self.world.site.controller.lockout
        if self.fault.insisted and lockout is not None and lockout.trips > 1:
            return "write a lower safety.lockout.trips, or use a heater of less power"
        off_s = self.world.peaks.latest_off_s(node, bears_c)
        rule = RULES[self.first.code].id if self.first else None
        late_s = (self.first.time_s if self.first else self.world.now_s) - self.cause_s
        path = f"loops.{self.world.site.loop_name}.protection"
        for key, value_s, trips in _lasting(self.world.site.loop.protection):
            shorter_s = value_s - (late_s - off_s)
            if rule in trips and shorter_s > 0 and self._health_bears(key, shorter_s):
                return f"write {path}.{key}: {_rounded_down(shorter_s):g} s"
        unseen = rule is None and self.fault.sensor_lies
        if unseen and off_s > 0 and self._health_bears("frozen.for", off_s):
            return f"make a rule trip within {_rounded_down(off_s):g} s with {path}.frozen.for"
        return "use a heater of less power, limit its power, or add a safety relay"

    def _health_bears(self, key: str, shorter_s: float) -> bool:
        """Whether a healthy machine still holds its highest setpoint with a shorter time of a rule.

        A value that `check` refuses is no remedy.
        """
        site = self.world.site
        protection, (rule, ended) = site.loop.protection, (*key.split("."), "")[:2]
        part = getattr(protection, rule, None)
        if not isinstance(part, Heating | Frozen):
            return True
        changed = part.model_copy(update={f"{ended}_s": _rounded_down(shorter_s)})
        loop = site.loop.model_copy(
            update={"protection": protection.model_copy(update={rule: changed})}
        )
        other = replace(site, controller=site.controller.with_loop(site.loop_name, loop))
        refused = ("loops", site.loop_name, "protection", rule)
        if any(finding.path[:4] == refused for finding in check(other.controller)):
            return False
        return highest_c(other) >= highest_c(site)

    def _holds(self, latched: Change, when: str) -> None:
        """Check that the fault stays latched and shown, with every heater off since the trip."""
        world = self.world
        world.run(REST_S)
        if world.fault != latched.code:
            self._wrong(f"{_name(world.fault)} is latched {when}, not {_name(latched.code)}")
        on_s = world.heaters.last_on_s(latched.time_s + TICK_S)
        if on_s is not None:
            self._wrong(
                f"a heater was on {on_s - latched.time_s:.3f} s after the trip, found {when}"
            )
        for loop in world.site.controller.loops.values():
            heater = world.device.outputs[loop.heater]
            if heater.on or not (heater.driven or self.fault.floats):
                self._wrong(f"the pin of {loop.heater} is not driven to off {when}")
        others = (coolers.complaint(world), relays.complaint(world, floats=self.fault.floats))
        for complaint in (*notices.complaints(world, latched.code), *others):
            if complaint:
                self._wrong(f"{complaint} {when}")

    # -- acknowledgements ----------------------------------------------------------------------

    def _again(self) -> Change | None:
        """Acknowledge while the cause lasts; return None if no rule trips again.

        A second press of SELECT, to switch the loop on, may acknowledge the next trip: then the
        trip after that one counts.
        """
        began_s = self.world.now_s
        self.world.acknowledge()
        began_s = max(began_s, self.world.trips.acknowledged_s())
        latched = self._wait(began_s, " after the acknowledgement")
        if latched is not None:
            self._holds(latched, "after the next trip")
        return latched

    def _insisted(self) -> Change | None:
        """Acknowledge and command heat at each trip, until the lock-out needs a person.

        Return the fault that is latched at the end, or None.
        """
        world, lockout = self.world, self.world.site.controller.lockout
        most_s = (lockout.trips if lockout else 1) * (longest_rule_s(world.site) + LATE_S)
        ends_s = world.now_s + max(INSISTED_S, most_s)
        while world.now_s < ends_s and world.until(LATCHED, ends_s - world.now_s):
            if world.is_locked_out:
                ends_s = min(ends_s, world.now_s + REFUSED_S)
            self._moves_slowly()
            world.insist(highest_c(world.site))
            world.run(REST_S)
        world.until(SPREAD, SPREADING_S)
        self._judge_peaks()
        trips = world.trips.since(self.cause_s)
        if lockout is not None and _exceeds(trips, lockout):
            self._wrong(f"{len(trips)} trips were acknowledged although the lock-out was due")
        if not world.fault:
            return None
        self._holds(trips[-1], "after repeated acknowledgements")
        return trips[-1]

    def _moves_slowly(self) -> None:
        """Wait until the tip moves by half of what `rise_rate` allows: readings come in steps."""
        loop, before_c = self.world.site.loop, math.inf
        while abs(before_c - self.world.tip_c) > loop.rise_per_period_k / 2:
            before_c = self.world.tip_c
            self.world.run(loop.periods_s(1))

    def _clears(self) -> None:
        """Acknowledge after the cure: no fault may stay latched, and no rule may trip."""
        world = self.world
        if not world.site.controller.is_acknowledged:
            return
        since_s = world.now_s
        world.acknowledge()
        world.run(REST_S + world.site.loop.periods_s(3))
        if world.fault:
            self._wrong(f"{_name(world.fault)} is latched after its acknowledgement")
        elif world.trips.since(max(since_s, world.trips.acknowledged_s())):
            self._wrong("a rule tripped again although the cause was removed")


def _exceeds(trips: list[Change], lockout: Lockout) -> bool:
    """Return whether a rule tripped after the lock-out was due, with a `within` shorter by 1 s."""
    soon, last_s = 0, -math.inf
    for trip in trips:
        if soon == lockout.trips:
            return True
        soon = soon + 1 if trip.time_s - last_s < lockout.within_s - 1.0 else 1
        last_s = trip.time_s
    return False


def _name(code: int) -> str:
    return RULES[code].id if code else "no fault"


def _lasting(protection: Protection) -> Iterator[tuple[str, float, tuple[str, ...]]]:
    """Yield the keys that set how long rules take, their values in s, and the rules."""
    if protection.heating:
        yield "heating.within", protection.heating.within_s, ("heating_failed",)
    if protection.frozen:
        yield "frozen.for", protection.frozen.for_s, ("sensor_frozen",)
    if protection.runaway:
        yield "runaway.for", protection.runaway.for_s, ("runaway_above", "runaway_below")
    yield "stale_after", protection.stale_after_s, SENSOR_RULES


def _rounded_down(seconds: float) -> float:
    """Round down to two significant digits."""
    unit = 10.0 ** (math.floor(math.log10(seconds)) - 1)
    return math.floor(seconds / unit) * unit
