"""Repeated trips: on the binary, beside the model, and in the log that a replay holds to it."""

import numpy as np
import pytest
from rig.firmware import began_s, changed, controller_of, device_of, whole

from heatwright.sim.bench import ReferenceDevice
from heatwright.sim.device import AvrDevice
from heatwright.sim.judges.lockouts import miscounts
from heatwright.sim.replay import replay

COLD_C, HOT_C, TOO_HOT_C = 20.0, 200.0, 500.0
EXTRUDER = changed(
    "extruder", ("watchdog: 1 s", "watchdog: 1 s\n  lockout: {within: 1 min, wait: 5 s}")
)
CHAMBER = changed("chamber", ("watchdog: 2 s", "watchdog: 2 s\n  lockout: {trips: 2, hold: 3 s}"))


class Both:
    def __init__(self, spec: str) -> None:
        self.controller = controller_of(spec)
        self.device = AvrDevice(self.controller, whole(spec))
        self.model = ReferenceDevice(self.controller)
        self.sensor = next(iter(self.controller.loops.values())).sensor
        self.now_s = 0.0
        self.feel(COLD_C, 1.0)

    def run(self, seconds: float) -> None:
        self.now_s += seconds
        for each in (self.device, self.model):
            each.advance(self.now_s)

    def feel(self, celsius: float, seconds: float) -> None:
        for each in (self.device, self.model):
            each.sense(self.sensor, celsius)
        self.run(seconds)

    def say(self, line: str) -> None:
        for each in (self.device, self.model):
            each.send(line)
        self.run(0.5)

    def press(self, for_s: float, rest_s: float = 1.5) -> None:
        for key, seconds in ((None, rest_s), ("select", for_s), (None, 0.5)):
            for each in (self.device, self.model):
                each.press(key)
            self.run(seconds)

    def trip(self) -> None:
        self.feel(TOO_HOT_C, 1.5)
        self.feel(COLD_C, 0.5)
        assert self.latched

    @property
    def latched(self) -> bool:
        said = int(self.device.read("fault.code"))
        assert said == self.model.fault
        return said != 0

    @property
    def trips(self) -> int:
        return int(self.device.read("fault.trips"))

    def counts_as_the_model(self) -> bool:
        name = next(iter(self.controller.loops))
        return not list(miscounts(self.controller, self.device.steps(name), name))


def locked_out() -> Both:
    both = Both(EXTRUDER)
    for trip in range(1, 4):
        both.trip()
        assert both.trips == trip
        both.say("M999")
        assert both.latched == (trip == 3)
    return both


def test_a_host_is_refused_after_three_trips_through_resets_until_the_power_was_off() -> None:
    """A reset is no loss of power; and that has to be 5 s ago."""
    both = locked_out()
    device = both.device
    told = device.host.texts("echo:M999 refused")
    assert told == ["echo:M999 refused: locked out after repeated faults; at the machine, take "
                    "all power away, the USB's too, for a minute, and wait 5 s"]  # fmt: skip
    assert both.counts_as_the_model()

    def acknowledged_at(seconds: float) -> bool:
        device.advance(device.powered_s + began_s(EXTRUDER) + seconds)
        device.send("M999")
        device.advance(device.time_s + 0.5)
        return int(device.read("fault.code")) == 0

    device.avr.reset("external")
    device.advance(device.time_s + 10.0)
    device.send("M999")
    device.advance(device.time_s + 1.0)
    assert (device.read("fault.code"), device.read("fault.trips")) == (both.model.fault, 3)
    device.power_cycle()
    device.sense(both.sensor, COLD_C)
    assert not acknowledged_at(4.0)
    assert acknowledged_at(5.1)
    assert device.read("fault.trips") == 0
    assert both.counts_as_the_model()


def test_a_trip_that_is_long_past_counts_no_more() -> None:
    """Each less than a minute after the one before; no other rule counts."""
    both = Both(EXTRUDER)
    for _ in range(3):
        both.say("M112")
        both.say("M999")
    assert both.trips == 0
    for wait_s, trips in ((50.0, 1), (50.0, 2), (62.0, 1), (1.0, 2)):
        both.run(wait_s)
        both.trip()
        both.say("M999")
        assert (both.trips, both.latched) == (trips, False)
    assert both.counts_as_the_model()


def test_a_count_outlives_a_loss_of_power() -> None:
    both = Both(EXTRUDER)
    for _ in range(2):
        both.trip()
        both.say("M999")
    both.run(1.0)
    both.device.power_cycle()
    both.device.sense(both.sensor, COLD_C)
    for since_s, trips in ((59.0, 2), (61.0, 0), (62.0, 0)):
        both.device.advance(both.device.powered_s + since_s)
        assert both.trips == trips
    both.device.power_cycle()
    both.device.advance(both.device.powered_s + 1.0)
    assert both.trips == 0
    assert both.counts_as_the_model()


@pytest.mark.parametrize(
    ("held_s", "rest_s", "ends"),
    [(0.1, 1.5, False), (2.9, 1.5, False), (3.1, 1.5, True), (5.9, 1.5, True), (6.2, 1.5, False),
     (3.1, 0.0, False)],
)  # fmt: skip
def test_select_is_held_to_end_a_lock_out(held_s: float, rest_s: float, ends: bool) -> None:
    both = Both(CHAMBER)
    both.run(1.5)
    for _ in range(2):
        both.feel(300.0, 2.0)
        both.feel(COLD_C, 2.0)
        assert both.latched
        both.press(0.1)
    assert (both.trips, both.latched) == (2, True)
    assert both.device.shield.lcd.text[1] == "E06 HOLD SELECT "
    if not rest_s:
        both.press(0.1)
    both.press(held_s, rest_s)
    assert both.latched != ends
    assert both.trips == (0 if ends else 2)
    assert both.counts_as_the_model()


def test_a_replay_finds_a_count_that_is_wrong() -> None:
    """One trip more or less, and an acknowledgement of what is locked out."""
    both = locked_out()
    log = both.device.steps("nozzle")
    assert replay(both.controller, log).mismatches == 0
    seen = log["fault.trips"]
    for trips in (np.minimum(seen, 2), seen + 1, seen * 0):
        wrong = log.copy()
        wrong["fault.trips"] = trips
        assert replay(both.controller, wrong).mismatches > 0
    wrong = log.copy()
    wrong["fault.acknowledgements"][-1] += 1
    wrong["fault.code"][-1] = wrong["fault.trips"][-1] = 0
    assert "locked out" in str(next(miscounts(both.controller, wrong, "nozzle")))


@pytest.mark.parametrize("trips_s", [(9.05,), (9.05, 189.05)], ids=["once", "as it expires"])
def test_trips_between_two_steps_of_a_slow_loop_age_from_their_time(
    trips_s: tuple[float, ...],
) -> None:
    """The other loop's, acknowledged before the slow one's next step: only their time is told."""
    spec = changed(
        "printer",
        ("watchdog: 1 s", "watchdog: 1 s\n  lockout: {within: 3 min, wait: 5 s}"),
        ("period: 500 ms", "period: 2 s"),
    )
    controller = controller_of(spec)
    device = device_of(spec, COLD_C)
    for trip_s in trips_s:
        device.advance(trip_s)
        device.sense("nozzle", HOT_C)  # a leap
        device.advance(trip_s + 0.25)
        device.sense("nozzle", COLD_C)
        device.advance(trip_s + 0.55)
        device.send("M999")
    device.advance(400.0)
    log = device.steps("bed")
    assert not log["fault.code"].any()
    counted = np.flatnonzero(log["fault.trips"])
    assert set(log["fault.time_s"][counted]) == {int(each - began_s(spec)) for each in trips_s}
    assert 0 < counted[0] < counted[-1] < len(log) - 1
    assert not list(miscounts(controller, log, "bed"))
