"""How every fault is tried: cause, trip, acknowledgement, cure, loss of power, acknowledgement.

Where nothing may trip, it is watched for a while. Where a rule must trip, it has to

1. trip in time, with the right rule, and the heater has to be off;
2. show its number and words on the display, and tell the host;
3. trip again when it is acknowledged while the cause goes on;
4. stay latched when the cause has gone, and through a loss of power;
5. go away when it is acknowledged then.

From each trip to its acknowledgement no heater's pin may be on for a single cycle.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from heatwright.sim.faults import cooling, relays, told
from heatwright.sim.faults.bounds import TICK_S
from heatwright.sim.faults.fault import Fault, FaultResult, Trip
from heatwright.sim.faults.records import Change
from heatwright.sim.faults.world import World
from heatwright.sim.interlock import overlaps
from heatwright.spec.rules import RULES

LATE_S = 5.0
"""How much longer than allowed is waited, to tell late from never."""
REST_S = 2.0
"""How long a latched fault is watched. Longer than a display needs for both lines (one cell a tick,
after its start-up of at most ten) and an EEPROM for a record (one byte a tick)."""

SHOWN_S = 0.1
"""How long after a trip its peak is still looked for; a gate is closed in a tenth of that."""

COOLER_K = 5.0
COOLING_S = 4 * 3600.0


def try_fault(fault: Fault) -> FaultResult:
    """Try a fault on a world of its own."""
    trial = _Trial(fault, fault.make())
    trial.run()
    return trial.result()


@dataclass
class _Trial:
    """One fault on its way through the procedure.

    first -- the trip that is reported; latched -- the present one; since_s -- when the condition of
    the first was met.
    """

    fault: Fault
    world: World
    problems: list[str] = field(default_factory=list)
    first: Change | None = None
    cause_s: float = 0.0
    since_s: float = 0.0
    off_s: float | None = None
    peak_c: float = 0.0

    def run(self) -> None:
        if self.world.fault and not self.fault.may:
            self._wrong(f"{_name(self.world.fault)} was latched before it began")
            return
        self.cause_s = self.since_s = self.world.now_s
        self.world.peak_c = self.world.sensed_c
        self.fault.cause(self.world)
        if self.fault.trip:
            self._must_trip(self.fault.trip)
        else:
            self._may_not_trip()
        judged = self.fault.judge(self.world)
        self.world.device.feed()
        for complaint in (judged, *overlaps(self.world.device.interlocks)):
            if complaint:
                self._wrong(complaint)

    def result(self) -> FaultResult:
        first, trip = self.first, self.fault.trip
        return FaultResult(
            fault=self.fault.id,
            rule=RULES[first.code].id if first else None,
            expected=trip.rules if trip else (),
            tripped_after_s=first.time_s - self.since_s if first else None,
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
        self.peak_c = self.world.peak_c
        trips = self.world.trips.since(self.cause_s)
        trips = [trip for trip in trips if RULES[trip.code].id not in self.fault.may]
        if trips:
            self.first = trips[0]
            self._wrong(f"{_name(trips[0].code)} tripped for no reason")

    # -- a rule must trip ----------------------------------------------------------------------

    def _must_trip(self, trip: Trip) -> None:
        self.first, self.since_s = self._wait(trip, self.cause_s, "")
        if self.first is None:
            return
        self._judge_heater()
        latched = self.first
        self._holds(latched, "after the trip")
        self.peak_c = self.world.peak_c
        if self.fault.again:
            latched = self._again(self.fault.again) or latched
        self.fault.cure(self.world)
        self._cools_down()
        self._holds(latched, "when its cause has gone")
        self.world.power_cut()
        self._holds(latched, "after a loss of power")
        self._clears()

    def _cools_down(self) -> None:
        """Wait until the machine has left its maximum, which would rightly trip again.

        And until it is where it may be asked to be: beyond, one step of an analog sensor may pass
        for a jump.
        """
        loop = self.world.site.loop
        limit_c = min(loop.protection.maximum_c - COOLER_K, loop.setpoint.maximum_c)
        self.world.until(lambda now: now.sensed_c < limit_c, COOLING_S)

    def _wait(self, trip: Trip, began_s: float, when: str) -> tuple[Change | None, float]:
        """Wait for a trip; return it, and since when its condition had been met."""
        world = self.world
        since_s = self._follow(trip, began_s)
        if since_s is None:
            self._wrong(f"its condition was not met within {trip.due_within_s:g} s{when}")
            return None, world.now_s
        trips = world.trips.since(began_s)
        if not trips:
            self._wrong(f"nothing tripped{when}")
            return None, since_s
        self._judge_trip(trip, trips[0], since_s, when)
        return trips[0], since_s

    def _follow(self, trip: Trip, began_s: float) -> float | None:
        """Go on until a fault is latched, or much too late.

        Return since when the condition had been met without a gap: the step of time in which it
        was met counts. A trip that comes sooner counts from the step of time before it.
        """
        world = self.world
        since_s: float | None = None
        give_up_s = began_s + trip.due_within_s
        while not _is_latched(world):
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
        if RULES[found.code].id not in trip.rules:
            self._wrong(f"{_name(found.code)} tripped, not {' or '.join(trip.rules)}{when}")
        after_s = found.time_s - since_s
        if after_s > trip.allowed_s:
            self._wrong(f"tripped after {after_s:.3f} s, not within {trip.allowed_s:.3f} s{when}")

    def _judge_heater(self) -> None:
        """See how soon the heater was off."""
        limit_s = self.fault.off_within_s
        since_s = self.since_s if limit_s is None else self.cause_s
        self.world.run(SHOWN_S)
        last_on_s = self.world.heaters.last_on_s(since_s)
        self.off_s = 0.0 if last_on_s is None else last_on_s - since_s
        if limit_s is not None and self.off_s > limit_s:
            self._wrong(f"heater off after {self.off_s:.3f} s, not within {limit_s:.3f} s")

    def _holds(self, latched: Change, when: str) -> None:
        """See that it stays latched and shown, and that no heater has been on since the trip."""
        world = self.world
        world.run(REST_S)
        if world.fault != latched.code:
            self._wrong(f"{_name(world.fault)} is latched {when}")
        on_s = world.heaters.last_on_s(latched.time_s + TICK_S)
        if on_s is not None:
            self._wrong(
                f"a heater was on {on_s - latched.time_s:.3f} s after the trip, seen {when}"
            )
        for loop in world.site.controller.loops.values():
            heater = world.device.outputs[loop.heater]
            if heater.on or not heater.driven:
                self._wrong(f"{loop.heater} is not driven to off {when}")
        others = (cooling.complaint(world), relays.complaint(world))
        for complaint in (*told.complaints(world, latched.code), *others):
            if complaint:
                self._wrong(f"{complaint} {when}")

    # -- acknowledgements ----------------------------------------------------------------------

    def _again(self, again: Trip) -> Change | None:
        """Acknowledge while the cause goes on."""
        if not self.world.site.has_operator:
            return None
        began_s = self.world.now_s
        self.world.acknowledge()
        trip, _ = self._wait(again, began_s, " when acknowledged")
        if trip:
            self._holds(trip, "after it tripped again")
        return trip

    def _clears(self) -> None:
        """Acknowledge when the cause has gone: nothing may stay, nothing may come."""
        world = self.world
        if not world.site.has_operator:
            return
        since_s = world.now_s
        world.acknowledge()
        world.run(REST_S + 3 * world.site.loop.period_s)
        if world.fault:
            self._wrong(f"{_name(world.fault)} is latched after its acknowledgement")
        elif world.trips.since(since_s):
            self._wrong("it tripped again although its cause had gone")


def _is_latched(world: World) -> bool:
    return world.fault != 0


def _name(code: int) -> str:
    return RULES[code].id if code else "no fault"
