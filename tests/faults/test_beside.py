"""Faults of what is watched beside a loop's own sensor, in machines with each interface."""

from functools import cache
from itertools import product

import pytest
from fault_machines import faults_of, judged, site_of
from rig.firmware import changed, controller_of, edited

from heatwright.sim.faults import starts
from heatwright.sim.faults.machine_parts.monitors import untold
from heatwright.sim.faults.world import World
from heatwright.sim.native.relay import Wire

DS18B20 = "{kind: ds18b20, pin: PIN, resolution: 9 bit}"
THERMISTOR = (
    "{kind: thermistor, pin: PIN, divider: {pull_up: 4.7 kΩ}, curve: {resistance: 100 kΩ, "
    "at: 25 °C, beta: 3950 K}, range: 0 °C .. 150 °C, oversample: 2}"
)
HOT_ONE = (
    "{kind: thermistor, pin: PIN, divider: {pull_up: 4.7 kΩ}, curve: {resistance: 100 kΩ, "
    "at: 25 °C, beta: 4267 K}, range: 0 °C .. 300 °C, oversample: 4}"
)


def doubled(example: str, second: str, place: str, limits: str, agreement: str) -> str:
    """Give a machine's first loop a second sensor; place -- in the plant."""
    name = next(iter(controller_of(example).loops))
    return edited(example, f"""
sensors.twin: {second}
loops.{name}.also: twin
loops.{name}.protection.agreement: {agreement}
monitors: {{twin: {{sensor: twin, {limits}}}}}
simulation.plant.sense.twin: {place}
""")  # fmt: skip


DOUBLED = {
    "chamber": doubled(
        "chamber", DS18B20.replace("PIN", "A2"), "{node: air, lag: 10 s}",
        "warning: 80 °C, limit: 90 °C", "{within: 6 K, for: 20 s}",
    ),
    "extruder": doubled(
        "extruder", HOT_ONE.replace("PIN", "A14"), "{node: block, lag: 2 s}",
        "warning: 280 °C, limit: 295 °C, hysteresis: 6 K", "{within: 15 K, for: 5 s}",
    ),
}  # fmt: skip

TOLD_BY_HEAT = {("chamber", "sensor_drifts_low"), ("chamber", "sensor_creeps_out")}
"""It warms its air so slowly that a reading that falls meanwhile does not rise at full power."""


@pytest.mark.parametrize("machine", DOUBLED)
@pytest.mark.parametrize(
    "fault", ["sensor_drifts_low", "second_sensor_drifts_low", "sensor_creeps_out"]
)
def test_one_that_lies_plausibly_is_told(machine: str, fault: str) -> None:
    rule = "heating_failed" if (machine, fault) in TOLD_BY_HEAT else "sensors_disagree"
    assert judged(DOUBLED[machine], fault) == rule


@pytest.mark.parametrize("machine", DOUBLED)
@pytest.mark.parametrize("fault", ["monitor_twin_torn", "monitor_twin_shorted", "small_jumps"])
def test_the_second_one_s_own_faults(machine: str, fault: str) -> None:
    judged(DOUBLED[machine], fault)


def test_without_a_reading_of_the_second_nothing_heats() -> None:
    world = starts.heating(site_of(DOUBLED["chamber"]))
    sensor = world.device.sensors["twin"]
    sensor.unplug()
    torn_s = world.now_s
    world.run(2.5)
    world.device.feed()
    last_s = world.heaters.last_on_s(torn_s)
    assert last_s is None or last_s - torn_s < 2.1
    assert world.fault == 0
    sensor.plug()
    assert world.until(starts.heater_on(world.site), 10.0)


MONITORED = {
    "chamber": (DS18B20, "A2", "A3", 1), "kiln": (DS18B20, "A4", "A5", 2),
    "kiln_uno": (DS18B20, "A3", "A4", 2), "extruder": (THERMISTOR, "A3", "A4", 1),
    "fabricator": (THERMISTOR, "PA4", "PA5", 1),
}  # fmt: skip
"""A panel, a touch display with a log, a menu, a host, a master: the lamp's sensor, its pin and the
other's, and how many tell of warnings."""
RULES = {
    DS18B20: {"torn": "sensor_no_answer", "shorted": "sensor_short"},
    THERMISTOR: {"torn": "sensor_open", "shorted": "sensor_short"},
}


@cache
def monitored(example: str) -> str:
    lamp, *pins, _ = MONITORED[example]
    links = len(controller_of(example).simulation.plant.links)
    return edited(example, f"""
sensors.lamp: {lamp.replace("PIN", pins[0])}
sensors.box: {THERMISTOR.replace("PIN", pins[1])}
monitors.lamp: {{sensor: lamp, warning: 100 °C, limit: 110 °C, stale_after: 20 s}}
monitors.drivers_of_motors: {{sensor: box, warning: 60 °C, limit: 80 °C}}
simulation.plant.nodes.box: 300 J/K
simulation.plant.links.{links}: {{between: [box, ambient], resistance: 3 K/W}}
simulation.plant.sense.lamp: {{node: box}}
simulation.plant.sense.box: {{node: box, lag: 5 s}}
""")  # fmt: skip


CASES = [
    (example, f"monitor_{name}_{what}", rule)
    for example, (lamp, *_) in MONITORED.items()
    for name, kind in (("lamp", lamp), ("drivers_of_motors", THERMISTOR))
    for what, rule in {**RULES[kind], "over_limit": "monitor_limit", "warns": None}.items()
]


@pytest.mark.parametrize(("example", "name", "rule"), CASES)
def test_it_trips_its_rule_or_warns(example: str, name: str, rule: str | None) -> None:
    assert judged(monitored(example), name) == rule


@pytest.mark.parametrize("example", MONITORED)
def test_who_is_not_told_is_found(example: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where RAM alone had a warning, each interface would lack it."""
    world = faults_of(monitored(example))["monitor_lamp_warns"].make()
    read = world.device.read
    monkeypatch.setattr(world.device, "read", lambda name: "warns" in name or read(name))
    assert len(list(untold(world))) == MONITORED[example][-1]


@pytest.mark.parametrize("fault", ["switch_shorted_when_hot", "fire"])
def test_a_monitor_that_trips_below_the_loops_maximum_lets_each_fault_begin(fault: str) -> None:
    text = edited("chamber", f"""
sensors.outlet: {DS18B20.replace("PIN", "A2")}
monitors.outlet: {{sensor: outlet, warning: 74 °C, limit: 78 °C}}
simulation.plant.sense.outlet: {{node: air, lag: 5 s}}
""")  # fmt: skip
    assert judged(text, fault) == "monitor_limit"


PINS = {
    "chamber": ("A2", "A3"), "kiln": ("A4", "A5"), "kiln_uno": ("A3", "A4"),
    "printer": ("D41", "A5"), "fabricator": ("PD2", "PB4"),
}  # fmt: skip
"""A panel; a touch display, a menu: both with programs and a relay; a host with two loops; a
master, a cooler, a watched current and a relay. The pins of the door and of the stop."""
KEPT = ("gate.c:input_ticks", "gate.c:air_paused", "inputs.c:found", "inputs.c:stop_ticks")
"""What the firmware keeps of them, in bytes."""


def with_inputs(example: str) -> str:
    door, stop = PINS[example]
    return edited(example, f"""
safety.inputs: {{door: {{pin: {door}, trips: false, for: 30 ms}}, stop: {{pin: {stop}}}}}
""")  # fmt: skip


SHUT = with_inputs("chamber")


@pytest.mark.parametrize("example", PINS)
@pytest.mark.parametrize(
    ("fault", "rule"),
    [("input_stop_opens", "input_open"), ("input_door_opens", None),
     ("input_stop_bounces", None), ("input_door_bounces", None)],
)  # fmt: skip
def test_nothing_heats_while_one_is_open(example: str, fault: str, rule: str | None) -> None:
    assert judged(with_inputs(example), fault) == rule


def opened(name: str) -> World:
    world = starts.heating(site_of(SHUT))
    world.device.contacts[name].move(is_open=True)
    world.run(0.1)
    return world


@pytest.mark.parametrize("variable", KEPT)
@pytest.mark.parametrize("name", ["door", "stop"])
def test_no_flipped_bit_heats_while_one_is_open(name: str, variable: str) -> None:
    world = opened(name)
    place = world.device.variables[variable].address
    for bit in range(8):
        flipped_s = world.now_s
        world.device.avr.flip(place, bit)
        world.run(0.2)
        world.device.feed()
        assert world.heaters.last_on_s(flipped_s) is None


@pytest.mark.parametrize("register", ["PORT", "DDR"])
@pytest.mark.parametrize("is_open", [False, True])
def test_a_pin_s_registers_are_written_anew(register: str, is_open: bool) -> None:
    site = site_of(SHUT)
    pin = site.controller.board.pins[site.controller.safety.inputs["stop"].pin]
    world = opened("door") if is_open else starts.heating(site)
    place = world.device.variables[f"{register}{pin.port}"].address
    before = world.device.avr.read_ram(place, 1)[0] & 1 << pin.bit
    world.device.avr.flip(place, pin.bit)
    world.run(0.1)
    assert world.device.avr.read_ram(place, 1)[0] & 1 << pin.bit == before


def test_an_open_contact_outlives_a_loss_of_power() -> None:
    world = opened("stop")
    world.power_cut()
    cut_s = world.power_on_s
    world.run(5.0)
    world.device.feed()
    assert world.heaters.last_on_s(cut_s) is None
    assert world.fault


PROVEN = edited("chamber", """
outputs.fan: {kind: digital, pin: D11, active: low, runs: always, proof: {pin: A3, within: 2 s}}
""")  # fmt: skip
SHARED = edited("printer", """
outputs.air: {kind: digital, pin: D11, runs: always, proof: {pin: D6, within: 3 s}}
loops.hotend.fan: air
loops.bed.fan: air
""")  # fmt: skip
"""Two loops with one fan: the first one's step judges it, both are without heat."""
COUNTED = edited(SHARED, """
outputs.air.active: low
outputs.air.proof.tachometer: {speed: 5800 rpm, pulses: 3, minimum: 900 rpm, maximum: 7000 rpm}
""")  # fmt: skip
"""As fast, and with limits as far apart, as can be counted."""
FANS = {
    "dryer": ("dryer", "fan"), "incubator": ("incubator", "fan"),
    "counted": (COUNTED, "hotend.air"), "chamber": (PROVEN, "fan"),
    "printer": (SHARED, "hotend.air"),
}  # fmt: skip

COUNTED_ALONE = ("weak", "proof_shorted", "proof_noisy")
WITH_TACHOMETER = ("incubator", "counted")

UNPROVEN = [*product(FANS, ("stuck", "proof_torn")), *product(WITH_TACHOMETER, COUNTED_ALONE)]


@pytest.mark.parametrize(("machine", "what"), UNPROVEN)
def test_no_heat_without_proof(machine: str, what: str) -> None:
    spec, fan = FANS[machine]
    assert judged(spec, f"{fan}_{what}") == "fan_stopped"


@pytest.mark.parametrize("machine", WITH_TACHOMETER)
@pytest.mark.parametrize("what", ["turns_slow", "turns_fast"])
def test_a_fan_at_its_limits_is_proof(machine: str, what: str) -> None:
    spec, fan = FANS[machine]
    assert judged(spec, f"{fan}_{what}") is None


def test_air_that_comes_back_in_time_is_no_fault() -> None:
    """The heater is off meanwhile, and on again."""
    world = faults_of("dryer")["fan_stuck"].make()
    proof = world.device.proofs["fan"]
    for _ in range(3):
        proof.fail(wire=Wire.TORN)
        world.run(0.1)
        torn_s = world.now_s
        world.run(2.0)
        assert (world.heater.last_on_s(torn_s), world.fault) == (None, 0)
        proof.fail()
        world.run(0.1)
        assert world.until(starts.heater_on(world.site), 10.0)


def test_both_loops_of_a_fan_are_without_heat() -> None:
    fault = faults_of(SHARED)["hotend.air_stuck"]
    world = fault.make()
    world.send("M140 S60")
    assert world.until(lambda now: now.device.outputs["bed_heater"].on, 10.0)
    fault.cause(world)
    world.run(0.1)
    stuck_s = world.now_s
    world.run(2.0)
    assert (world.heaters.last_on_s(stuck_s), world.fault) == (None, 0)


# The menu's keys are of the second loop; the first has a tip that rises by some steps of its sensor
# in 100 ms.
PAIR = changed(
    "kiln_uno",
    ("outputs:\n",
     "  tip:\n    {kind: thermistor, pin: A2, divider: {pull_up: 4.7 kΩ}, oversample: 1,\n"
     "     curve: {resistance: 100 kΩ, at: 25 °C, beta: 4267 K}, range: 0 °C .. 250 °C}\n\n"
     "outputs:\n  tip_heater: {kind: digital, pin: A3, power: 1.5 W}\n"),
    ("loops:\n",
     "loops:\n  tip:\n    sensor: tip\n    heater: tip_heater\n    period: 10 ms\n"
     "    setpoint: {initial: 60 °C, minimum: 40 °C, maximum: 80 °C}\n"
     "    algorithm: {kind: on_off, hysteresis: 10 K}\n"
     "    protection: {maximum: 120 °C, minimum: 5 °C, rise_rate: 120 K/s, stale_after: 2 s, "
     "runaway: {above: 20 K, for: 2 s}}\n"),
    ("sense: {", "sense: {tip: {node: tip, lag: 0.1 s}, "),
    ("nodes: {", "nodes: {tip: 0.1 J/K, "),
    ("links:\n", "links:\n      - {between: [tip, ambient], resistance: 346 K/W}\n"),
    ("heat: {", "heat: {tip_heater: tip, "),
)  # fmt: skip


@pytest.mark.parametrize("name", ["display_unplugged", "chamber.jump_down"])
def test_it_is_judged_by_what_all_loops_do(name: str) -> None:
    judged(PAIR, name)


def test_memory_is_damaged_where_a_sensor_is_missed_soonest() -> None:
    """A loop may bear its sensor's silence for a day; in the steps of a quick one that is much."""
    patient = changed(
        PAIR, ("period: 10 ms", "period: 2 s"), ("after: 2 s", "after: 500 s"),
        ("power: 1.5 W", "power: 0.2 W"), ("{tip: 0.1 J/K, ", "{tip: 2 J/K, "),
    )  # fmt: skip
    assert faults_of(patient)["record_cut_short"].make().now_s < 60
