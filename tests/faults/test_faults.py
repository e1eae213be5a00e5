"""Each fault, on the binary; and what the catalogue promises for any controller."""

import pytest
from fault_machines import MACHINES, expected, faults_of, judged, site_of, tried
from rig.bad_specs import bases
from rig.firmware import EXAMPLE_NAMES, ROOT, changed, controller_of, edited, whole
from rig.sensors import KEYS, bed

from heatwright.sim.faults import catalogue, starts, try_fault
from heatwright.sim.faults.controller.memory import cut_line
from heatwright.sim.faults.world import Site, Weather, World
from heatwright.sim.replay import replay_all
from heatwright.spec import Controller
from heatwright.spec.rules import RULES

TWO = edited("dryer", """
controller.board: atmega32
sensors.lid: {kind: ds18b20, pin: PC0, resolution: 9 bit}
outputs.lid_heater: {kind: digital, pin: PB2, power: 100 W}
loops.lid: {sensor: lid, heater: lid_heater, period: 300 ms, starts: disabled,
  setpoint: {initial: 40 °C, minimum: 30 °C, maximum: 60 °C},
  algorithm: {kind: on_off, hysteresis: 1 K}, protection: {maximum: 75 °C, stale_after: 3 s}}
interfaces.1.loop: air
simulation.plant.nodes.lid: 400 J/K
simulation.plant.links.2: {between: [lid, ambient], resistance: 1 K/W}
simulation.plant.links.3: {between: [lid, air], resistance: 5 K/W}
simulation.plant.heat.lid_heater: lid
simulation.plant.sense.lid: {node: lid}
""")  # fmt: skip
"""Another sensor, another period, an algorithm that switches."""
WARM_TWO = edited(TWO, "{loops.air.starts: enabled, loops.lid.protection.stale_after: 40 s}")
"""Where one sensor is lost, the other loop heats on until that is a fault."""
GENTLE = edited("fabricator", """
comparison: null
outputs.cooler: null
loops.nozzle.cooler: null
loops.nozzle.algorithm: {kind: pid, kp: 1, ki: 0.01}
loops.nozzle.protection.runaway: 'off'
simulation.plant.fans: null
interfaces.1.leds.PB2: null
""")  # fmt: skip
"""Its heater is shorted at a duty of 5 %, below that of a soft start."""
TENTHS = changed("fabricator", ("maximum: 320 °C", "maximum: 319.9 °C"))
"""A setpoint that single precision does not hold."""
SLOW = changed(
    "kiln_uno", ("    period: 1 s\n", "    period: 70 s\n"), ("after: 5 s", "after: 140 s")
)
SLOW_KEYS = edited(SLOW, """
controller.board: mega2560
sensors.lid: {kind: ds18b20, pin: D40}
outputs.lid_heater: {kind: digital, pin: D41, power: 100 W}
loops.lid: {sensor: lid, heater: lid_heater, period: 1 s,
  setpoint: {initial: 40 °C, minimum: 30 °C, maximum: 60 °C},
  algorithm: {kind: on_off, hysteresis: 1 K}, protection: {maximum: 75 °C, stale_after: 3 s}}
simulation.plant.nodes.lid: 400 J/K
simulation.plant.links.3: {between: [lid, ambient], resistance: 1 K/W}
simulation.plant.heat.lid_heater: lid
simulation.plant.sense.lid: {node: lid}
""")  # fmt: skip
"""The menu is of a loop that makes a step in 70 s; the other loop's fault is told at once."""
STOPPED = changed(
    "chamber", ("kind: serial_plotter, loop: air, baud: 9600", "kind: gcode, loops: {C: air}"),
    ("    starts: enabled  ", "    #"),
    ("initial: 20 °C, minimum: 10 °C", "initial: 0 °C, minimum: 0 °C"),
    ("period: 1 s", "period: 20 s"), ("stale_after: 5 s", "stale_after: 60 s"),
    ("within: 120 s", "within: 1 h"), ("above: 10 K", "above: 30 K"),
)  # fmt: skip
"""A host stops it in the middle of a long period."""
IDLE = edited("fabricator", """
interfaces: null
comparison: null
sensors.current: null
outputs.supply_relay: null
outputs.heater: {kind: digital, pin: PD5, power: 76.6 W}
loops.nozzle.starts: null
loops.nozzle.setpoint.initial: 21 °C
loops.nozzle.protection.master_lost_after: null
safety: {watchdog: 1 s}
simulation.plant.sense: {nozzle: {node: block, lag: 3 s}}
simulation.scenario: [{for: 10 s}]
""")  # fmt: skip
"""The room is within its dead band: neither heater nor cooler ever goes on."""
RELAYED = edited("fabricator", "{outputs.heater: {kind: pwm, pin: PD5, frequency: 1 kHz, "
    "power: 76.6 W, supply: 43 V, current: {sensor: current, trip: 4 A}}}")  # fmt: skip
"""A shorted wire takes more than the heater's full current through the relay."""
BESIDE = edited("printer", """
interfaces.0.loops: {T0: hotend}
loops.bed.setpoint: {initial: 60 °C, minimum: 30 °C, maximum: 110 °C}
loops.bed.autotune: null
simulation.scenario: [{for: 10 s}]
""")  # fmt: skip
"""Nobody commands the bed, but the hotend's host acknowledges its faults."""
KEYED_LID = edited("chamber", """
sensors.lid: {kind: ds18b20, pin: A2}
outputs.lid_heater: {kind: digital, pin: A3, power: 100 W}
loops.lid: {sensor: lid, heater: lid_heater, period: 1 s, starts: disabled,
  setpoint: {initial: 40 °C, minimum: 30 °C, maximum: 60 °C},
  algorithm: {kind: on_off, hysteresis: 1 K}, protection: {maximum: 75 °C, stale_after: 5 s}}
loops.air.starts: null
loops.air.setpoint.initial: 30 °C
interfaces.0.loop: lid
simulation.scenario: [{for: 10 s}]
simulation.plant.nodes.lid: 400 J/K
simulation.plant.links.3: {between: [lid, ambient], resistance: 1 K/W}
simulation.plant.heat.lid_heater: lid
simulation.plant.sense.lid: {node: lid}
""")  # fmt: skip
"""The display shows a loop that is off while another one is tried."""
RARELY_SAVED = edited("kiln_uno", "{programs.save_every: 1 h, "
    "programs.after_power_loss: {resume_within: 1 K, otherwise: pause}}")  # fmt: skip
"""After a loss of power it is much warmer than at the last save."""
KNOWN = {rule.id for rule in RULES.values()}
ELSEWHERE = {"monitor_limit", "fan_stopped", "input_open", "sensors_disagree"}
"""Rules of what only some machines have: test_beside.py trips them."""
CASES = [(machine, *each) for machine in MACHINES for each in tried(machine).items()]


@pytest.mark.parametrize(("machine", "name", "rule"), CASES)
def test_it_trips_its_rule_and_no_other(machine: str, name: str, rule: str | None) -> None:
    assert judged(machine, name) == rule


@pytest.mark.parametrize(
    "name", [name for name in EXAMPLE_NAMES if controller_of(name).lockout is not None]
)
def test_who_insists_at_the_worst_moment_heats_nothing_beyond_its_limit(name: str) -> None:
    """The feeder's block went to 291 °C, and bears 288 °C."""
    insisted = [each for each in faults_of(name).values() if each.insisted]
    assert insisted
    assert [try_fault(fault).detail for fault in insisted] == [""] * len(insisted)


@pytest.mark.parametrize(
    "protection", ["{}", "{rise_rate: 3 K/s, heating: 'off', frozen: {for: 80 s}}"]
)
def test_a_derived_lock_out_protects_however_the_reading_falls(protection: str) -> None:
    """Two readings shared the fall, so that `rise_rate` did not trip; a fall delayed `frozen`."""
    keyed = "{interfaces: [{kind: lcd_keypad, loop: air}], outputs.heater.power: 400 W, "
    text = edited(bases()["simulated_oven"], f"{keyed}loops.air.protection: {protection}}}")
    assert judged(text, "fallen_out_insisted")


@pytest.mark.parametrize("machine", MACHINES)
def test_the_catalogue_has_each_once_and_no_other(machine: str) -> None:
    """What the specification lets one expect, and nothing that nobody expects."""
    found = catalogue(site_of(machine).controller, site_of(machine).program)
    assert sorted(fault.id for fault in found) == sorted(expected(machine))
    assert {rule for fault in found if fault.trip for rule in fault.trip.rules} <= KNOWN


def test_the_readme_counts_the_trials_of_the_chamber() -> None:
    found = faults_of("chamber").values()
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert f"{len(found)} trials for the example `chamber`" in readme
    assert f"In {sum(fault.calm for fault in found)} of the trials no rule may trip" in readme


def test_every_rule_of_the_language_is_tripped_by_some_fault() -> None:
    assert {rule for _, _, rule in CASES} >= KNOWN - ELSEWHERE


def test_a_spec_without_machine(chamber: Controller) -> None:
    bare = chamber.model_copy(update={"simulation": None})
    with pytest.raises(ValueError, match="A machine is needed"):
        catalogue(bare, site_of("chamber").program)


@pytest.mark.parametrize(
    ("spec", "fault"),
    [
        *((TWO, f"lid.{fault}") for fault in ("unplugged", "switch_shorted_when_hot")),
        (TWO, "air.adc_stuck"), ("printer", "bed.adc_hangs"), ("printer", "hotend.adc_hangs"),
        (WARM_TWO, "lid.unplugged"), (GENTLE, "heater_shorted"), (SLOW, "relay_contact_shorted"),
        (SLOW_KEYS, "lid.unplugged"), (STOPPED, "host_stop"),
        (changed("fabricator", ("stale_after: 1 s", "stale_after: 5 s")), "adc_hangs"),
        (IDLE, "pin_held"), (RELAYED, "heater_shorted"), (BESIDE, "bed.fallen_out_insisted"),
    ],
)  # fmt: skip
def test_a_fault_of_one_loop_is_one_of_all(spec: str, fault: str) -> None:
    """Also one that both tell of in the same tick, as of a converter that both have."""
    assert judged(spec, fault)


def test_a_display_shows_again_what_it_showed() -> None:
    assert judged(KEYED_LID, "display_unplugged") is None


def test_a_program_that_is_rarely_saved_waits_after_a_loss_of_power() -> None:
    assert judged(RARELY_SAVED, "power_cut_in_program") is None


@pytest.mark.parametrize(
    "fault",
    ["sensor_lost_in_program", "hung_in_program", "power_cut_in_program", "power_cut_in_pause"],
)
def test_a_program_is_looked_at_when_a_step_has_taken_what_was_ordered(fault: str) -> None:
    """A start that no step has taken yet is not under way, and a pause makes nothing of it."""
    judged(SLOW, fault)


def test_a_setpoint_in_tenths_stays() -> None:
    judged(TENTHS, "bus_of_other_format")


def test_the_keys_of_a_menu_reach_what_is_asked_of_them() -> None:
    """In steps of their own, that lead from the initial setpoint to no tenth degree."""
    site = site_of(changed("kiln_uno", ("step: 1 K", "step: 7 K")))
    assert starts.setpoint_moved(starts.heating(site), starts.highest_c(site)) == ""


def test_no_machine_begins_colder_than_its_surroundings() -> None:
    """It would warm up by itself, which rules take for a runaway."""
    text = bed("hotend", interface=KEYS).replace("minimum: 10 °C", "minimum: 2 °C")
    text = text.replace("initial: 50 °C, minimum: 45 °C", "initial: 5 °C, minimum: 5 °C")
    world = starts.at_rest(site_of(text), above_k=0.0)
    assert world.setpoint_c == 5.0
    world.run(300.0)
    assert (world.fault, world.sensed_c) == (0, pytest.approx(20.0))


def test_a_fault_that_no_loop_accounts_for_is_a_mismatch() -> None:
    world = World(Site(controller_of(TWO), "lid", whole(TWO)), Weather(20.0, 20.0))
    world.run(2.0)
    cut_line(world)
    assert world.until(lambda now: now.fault != 0, 10.0)
    world.run(2.0)
    logs = {loop: world.device.steps(loop) for loop in ("air", "lid")}
    assert [each.mismatches for each in replay_all(controller_of(TWO), logs).values()] == [0, 0]
    (alone,) = replay_all(controller_of(TWO), {"air": logs["air"]}).values()
    assert [each.variable for each in alone.first] == ["fault.code"]
