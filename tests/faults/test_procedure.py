"""The procedure sees what is wrong; and a cause may come at any moment of the period."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from fault_machines import faults_of, judged, site_of
from numpy.typing import NDArray
from rig.firmware import changed
from rig.sensors import KEYS, bed

from heatwright.sim.faults import Fault, FaultResult, starts, try_fault
from heatwright.sim.faults.bounds import TICK_S, answer_s, gate_s, reading_s, watchdog_s
from heatwright.sim.faults.controller import memory
from heatwright.sim.faults.controller.processor import hang
from heatwright.sim.faults.machine import longest_rule_s
from heatwright.sim.faults.operation import notices
from heatwright.sim.faults.operation.operators import off_s
from heatwright.sim.faults.procedure import SHOWN_S, STILL_K, _Trial
from heatwright.sim.faults.records import Change, TripLog
from heatwright.sim.faults.site import OfState, State
from heatwright.sim.faults.world import SPREAD, STEP_S, Weather, World, below, switched
from heatwright.sim.machine import Beside, Heat
from heatwright.sim.sensors.current import CurrentProbe
from heatwright.sim.sensors.ds18b20 import Ds18b20
from heatwright.sim.trace import StepLog


def found(spoil: Callable[[Fault], Fault] = lambda fault: fault) -> FaultResult:
    return try_fault(spoil(faults_of("chamber")["unplugged"]))


def tripping(fault: Fault, **changes: Any) -> Fault:
    assert fault.trip is not None
    return replace(fault, trip=replace(fault.trip, **changes))


def making(fault: Fault, spoil: Callable[[World], object], **changes: Any) -> Fault:
    def make() -> World:
        world = fault.make()
        spoil(world)
        return world

    return replace(fault, make=make, **changes)


def forgetting(world: World) -> None:
    eeprom = world.device.avr.eeprom
    eeprom.contents = b"\xff" * eeprom.size


def cut_off(spoil: Callable[[World], object]) -> Callable[[Fault], Fault]:
    """With something done to the world before each loss of power, and no cure."""

    def spoilt(fault: Fault) -> Fault:
        def spoil_cuts(world: World) -> None:
            power_cut = world.power_cut

            def cut(off_s: float = 1.0, *, undefined: int = 0xFF) -> None:
                spoil(world)
                power_cut(off_s, undefined=undefined)
                fault.cause(world)

            world.power_cut = cut  # type: ignore[method-assign]

        return making(fault, spoil_cuts, cure=lambda _: None)

    return spoilt


def miscount(world: World) -> None:
    count = world.device.variables["guard_air.heating_steps"]
    world.device.avr.write_ram(count.address, bytes([8]))


def reads_three_quarters(world: World) -> None:
    """Give the sensor of the heater's current a wrong scale."""
    probe = world.device.sensors["current"]
    assert isinstance(probe, CurrentProbe)
    curve = probe._curve()
    bent = curve._replace(per_unit=0.75 * curve.per_unit)
    world.device.avr.adc.bend(probe.channel, bent)


def fragile(bears_c: float) -> Callable[[Fault], Fault]:
    """With air that bears no more, which `check` would have told."""

    def spoil(world: World) -> None:
        world._network = world._network.model_copy(update={"bears_c": {"air": bears_c}})

    return lambda _: making(faults_of("chamber")["frozen"], spoil)


SPOILT: dict[str, Callable[[Fault], Fault]] = {
    "tripped after 4.9.. s, not within 0.500 s": partial(tripping, allowed_s=0.5),
    "sensor_no_answer tripped, not over_temperature": partial(
        tripping, rules=("over_temperature",)
    ),
    "sensor_no_answer tripped for no reason": partial(replace, trip=None, calm=True, watch_s=10.0),
    "^sensor_crc tripped for no reason": lambda _: replace(
        faults_of("chamber")["damaged_answers"],
        judge=faults_of("chamber")["answers_damaged_in_bursts"].judge,
    ),
    "^nothing tripped; heater off after .*, not within": partial(replace, cause=lambda _: None),
    "its trip condition was not met within 1 s": lambda fault: replace(
        tripping(fault, due=lambda _: False, due_within_s=1.0), cause=lambda _: None
    ),
    "heater off after 0.9.. s, not within 0.010 s": partial(replace, off_within_s=TICK_S),
    "tripped again although|sensor_no_answer is latched after its ack": cut_off(lambda _: None),
    "no fault is latched after a loss of power, not sensor_no_answer": cut_off(forgetting),
    "sensor_no_answer was latched before the trial began": lambda fault: making(
        fault, lambda world: (fault.cause(world), world.run(10.0))
    ),
    "air differs from the reference model: step .* guard.heating_steps is": lambda fault: making(
        fault, miscount
    ),
    "air of air read .* °C at .* s, but its tip was at": lambda _: replace(
        faults_of("chamber")["frozen"], sensor_lies=False
    ),
    "nozzle measured 0.00 A at .* s, where .* A flowed": lambda _: replace(
        faults_of("fabricator")["current_sensor_torn"], current_lies=False
    ),
    "nozzle measured 1.33 A at .* s, where 1.78 to 1.78 A flowed": lambda _: making(
        faults_of("fabricator")["healthy_noisy"], reads_three_quarters
    ),
    "air reached .* °C but its limit is 70.0 °C.*write loops.air.protection.heating.within: .* s": (
        fragile(70.0)
    ),
    "air reached .* °C but its limit is 66.0 °C.* use a heater of less power": fragile(66.0),
    "the judge complains": partial(replace, judge=lambda _: "the judge complains"),
}


@pytest.mark.parametrize("finding", SPOILT)
def test_it_is_found(finding: str) -> None:
    result = found(SPOILT[finding])
    assert not result.passed
    assert re.search(finding, result.detail)


def test_a_heater_that_is_on_after_the_trip_is_found() -> None:
    """The pin is forced on as a short beside it would, ten ticks after the trip."""

    def cause(world: World) -> None:
        world.device.sensors["air"].unplug()  # type: ignore[attr-defined]
        world.until(lambda now: now.fault != 0, 10.0)
        world.run(0.1)
        world.device.avr.pins.drive("PD3", "high")
        world.run(0.1)
        world.device.avr.pins.drive("PD3", None)

    assert "a heater was on 0." in found(partial(replace, cause=cause)).detail


@pytest.mark.parametrize(
    ("fault", "again"), [("heat_from_elsewhere", False), ("switch_leaking", True)]
)
def test_after_a_trip_it_is_watched_as_long_as_it_moves(fault: str, again: bool) -> None:
    """A leak warms it for 15 minutes until a rule trips again; a constant heat changes nothing."""
    worlds: list[World] = []
    tried = making(faults_of("chamber")[fault], worlds.append)
    assert try_fault(tried).detail == ""
    slowest_s = longest_rule_s(worlds[0].site)
    assert (len(worlds[0].trips.since(0.0)) > 1) == again
    assert slowest_s < worlds[0].now_s < 3 * slowest_s < tried.watch_s


def test_a_machine_that_warms_slowly_is_watched_until_it_would_not_get_far() -> None:
    """With rules of one minute alone, it warms by less than 0.2 K in their time, and by 2 K yet."""
    text = changed(
        "chamber",
        ("heating: {rise: 2 K, within: 120 s}", "heating: off\n      frozen: off"),
        ("runaway: {above: 10 K, for: 60 s}", "rising_while_off: off\n      effort: off"),
    )
    fault = replace(faults_of(text)["small_jumps"], watch_s=4000.0)
    trial = _Trial(fault, starts.cold(site_of(text)))
    world, trial.first = trial.world, Change(0.0, 1)
    world.wiring.besides["heater"] = Beside(0.05, "air", 60.0)
    trial._watch()
    ended_s, ended_c = world.now_s, world.sensed_c
    world.run(fault.watch_s - ended_s)
    assert ended_s < fault.watch_s / 2
    assert world.sensed_c - ended_c < STILL_K


def test_of_a_dead_switch_nothing_is_judged_after_the_trip() -> None:
    """No rule can end its heat; and the machine bears what the rule takes to trip."""
    text = changed(
        bed("hotend", interface=KEYS),
        ("    bears: {plate: 100 °C}\n", ""), ("power: 120 W", "power: 3000 W"),
        ("period: 200 ms", "period: 1 s"), ("stale_after: 1 s", "stale_after: 5 s"),
        ("{node: plate, lag: 4 s}", "{node: plate}"),
        ("{above: 10 K, below: 10 K, for: 60 s}", "{above: 10 K, for: 60 s}"),
    )  # fmt: skip
    worlds: list[World] = []
    result = try_fault(making(faults_of(text)["switch_shorted_when_hot"], worlds.append))
    assert result.detail == ""
    times_s, tips_c = worlds[0].told("bed")
    trip_s = worlds[0].trips.since(0.0)[0].time_s
    seen_c = tips_c[times_s <= trip_s + SHOWN_S + 2 * STEP_S]
    assert result.peak_c <= seen_c.max()
    late_k = np.diff(seen_c).max() / STEP_S * reading_s(worlds[0].site.loop)
    assert worlds[0].bears_c["plate"] > 85.0 + late_k


@pytest.mark.parametrize("fault", ["contact_corrodes", "insulation_leaks"])
def test_a_spoilt_circuit_jumps_as_far_as_a_wide_rule_lets_pass(fault: str) -> None:
    """Twice the resistance of a thermistor is some 20 K: a jump is one of the reading."""
    text, wider = re.subn("rise_rate: .*", "rise_rate: 200 K/s", bed("hotend", interface=KEYS))
    assert wider
    judged(text, fault)


def test_json() -> None:
    near_s = partial(pytest.approx, abs=1)
    assert found().as_json() == {
        "fault": "unplugged", "loop": "air", "calm": False, "rule": "sensor_no_answer",
        "counting": ["effort_low", "sensor_no_answer"],
        "tripped_after_s": near_s(5), "allowed_s": 6.01,
        "heater_off_after_s": near_s(1),
        "peak": pytest.approx(65, abs=1), "passed": True, "detail": "",
    }  # fmt: skip


def stepped(counts: NDArray[np.int64], period_s: float) -> StepLog:
    log = np.zeros(len(counts), [("time_s", "f8"), ("steps", "u2")])
    log["time_s"], log["steps"] = 0.1 + period_s * np.arange(len(counts)), counts % 0x10000
    return log


def test_steps_are_in_time_however_often_their_counter_wraps() -> None:
    log = stepped(np.arange(1, 200_000), 0.04)
    assert off_s(log, 0.04) < TICK_S
    log["time_s"][150_000] += 0.05
    assert off_s(log, 0.04) == pytest.approx(0.05)


@pytest.mark.parametrize("counts", [[1, 2, 4, 5], [1, 2, 2, 3], [7, 8, 1, 2]])
def test_a_step_left_out_or_logged_twice_and_a_reset_are_not_in_time(counts: list[int]) -> None:
    assert off_s(stepped(np.array(counts), 0.04), 0.04) > 0.039


# ---- any moment of the period, also in the middle of an exchange ----

PHASES_S = (*np.arange(0.0, 1.0, 0.1), 0.2013, 0.2051, 0.9512, 0.9527, 0.9561, 0.9608, 0.9999)
any_phase = pytest.mark.parametrize("phase_s", PHASES_S, ids="{:.4f}".format)
CAUSES: dict[str, tuple[Callable[[Ds18b20], None], int]] = {
    "unplugged": (Ds18b20.unplug, 1),
    "shorted": (lambda chip: chip.short("low"), 2),
    "lifted": (lambda chip: chip.short("high"), 1),
}


def at_phase(phase_s: float) -> tuple[World, Ds18b20, float]:
    world = starts.heating(site_of("chamber"))
    at_s = float(np.ceil(world.now_s) + phase_s)
    world.run(at_s - world.now_s)
    world.device.advance(at_s)
    chip = world.device.sensors["air"]
    assert isinstance(chip, Ds18b20)
    return world, chip, at_s


def heated_on_s(world: World, since_s: float) -> float:
    last_on_s = world.heaters.last_on_s(since_s)
    assert last_on_s is not None
    return last_on_s - since_s


@any_phase
@pytest.mark.parametrize("cause", CAUSES)
def test_whenever_it_comes(cause: str, phase_s: float) -> None:
    world, chip, at_s = at_phase(phase_s)
    act, code = CAUSES[cause]
    act(chip)
    world.until(lambda now: now.fault != 0, 10.0)
    (trip,) = world.trips.since(0.0)
    assert trip.code == code
    assert trip.time_s - at_s <= answer_s(world.site.loop)
    assert heated_on_s(world, at_s) <= reading_s(world.site.loop)


@any_phase
def test_a_chip_that_browns_out_is_never_believed(phase_s: float) -> None:
    world, chip, _ = at_phase(phase_s)
    chip.brown_out()
    world.run(10.0)
    assert world.fault == 0
    read_c = world.device.steps("air")["temperature_c"]
    assert read_c[read_c > 0].max() < world.peak_c + 1


@pytest.mark.parametrize("phase_s", np.arange(0.0, 0.1, 0.007), ids="{:.3f}".format)
@pytest.mark.parametrize("entry", ["__stop_program", "_exit"])
def test_a_hang_whenever_it_comes(entry: str, phase_s: float) -> None:
    world = starts.heating(site_of("chamber"))
    at_s = world.now_s + phase_s
    world.device.advance(at_s)
    try:
        hang(world, entry)
    except ValueError:  # just awake
        world.device.advance(at_s + TICK_S / 2)
        hang(world, entry)
    limit_s = gate_s() if entry == "__stop_program" else watchdog_s(world.site)
    world.run(3.0)
    assert heated_on_s(world, at_s) <= limit_s + TICK_S / 2
    assert world.fault == 14


def test_watched_variables_end_a_wait_at_the_step_that_changes_them() -> None:
    def hot(state: State) -> bool:
        return state.loop("temperature_c") >= 40.0

    stepped, watched = starts.heating(site_of("chamber")), starts.heating(site_of("chamber"))
    assert stepped.until(hot, 300.0)
    assert watched.until(OfState(hot), 300.0)
    assert 0.0 < watched.now_s == stepped.now_s
    assert not watched.until(OfState(lambda state: state.fault != 0), 7.3)
    assert watched.now_s == pytest.approx(stepped.now_s + 7.3)


def test_the_machine_ends_a_wait_at_the_step_in_which_it_is_so() -> None:
    """As a look at each step does: for a switch, heat that spreads no further, a temperature."""
    ended_s: list[list[float]] = []
    for seen in (lambda condition: condition, partial):
        world = starts.heating(site_of("chamber"))
        at_s = [world.now_s]
        for condition in (switched(on=False), switched(on=True), SPREAD, below(60.0)):
            if condition is SPREAD:
                world.wiring.heat["heater"] = Heat(0.0)
                world.run(world.step_s)
            assert world.until(seen(condition), 600.0)
            at_s.append(world.now_s)
        ended_s.append(at_s)
    assert ended_s[0] == ended_s[1]
    assert len(set(ended_s[0])) == len(ended_s[0])


def test_keys_go_to_setpoints_that_single_precision_rounds_up() -> None:
    """One press is 9.9999996 K there."""
    site = site_of(changed("chamber", ("initial: 20 °C", "initial: 20.6 °C")))
    world = World(site, Weather(20.0, 20.0))
    world.run(3.0)
    assert world.setpoint_c > 20.6
    world.set_setpoint(30.6)
    assert starts.setpoint_moved(world, 30.6) == ""


def test_a_trip_is_waited_for_until_the_program_sleeps(monkeypatch: pytest.MonkeyPatch) -> None:
    """A step of time may end between the latch and its record."""
    recorded, late = TripLog.since, []

    def since(log: TripLog, time_s: float) -> list[Change]:
        found = recorded(log, time_s)
        if found and not late:
            late.append(found)
            return []
        return found

    monkeypatch.setattr(TripLog, "since", since)
    assert found().passed
    assert late


def test_whoever_acknowledges_over_a_slow_line_waits_until_it_is_done() -> None:
    """Whatever the master had asked before."""
    slow = changed("barrel", ("baud: 19200", "baud: 1200"))
    fault = faults_of(slow)["barrel.unplugged"]
    world = fault.make()
    fault.cause(world)
    world.until(OfState(lambda now: now.fault != 0), 20)
    for celsius in range(150, 158):
        world.device.write("barrel.setpoint", celsius)
    world.acknowledge()
    assert world.trips.acknowledged_s() > 0


@pytest.mark.parametrize(
    ("text", "for_s", "told"), [("", 0.001, 0), ("", 1.0, 1), ("E01 NO ANSWER?", 0.001, 1)]
)
def test_a_display_that_is_started_anew_is_read_once_more(
    text: str, for_s: float, told: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its second line is dark then, for less than a millisecond."""
    world = memory.latched(site_of("chamber"))
    shown, until_s = world.screen, world.now_s + for_s
    monkeypatch.setattr(
        World, "screen", property(lambda now: shown if now.now_s > until_s else ("", text))
    )
    assert len(list(notices.complaints(world, world.fault))) == told
