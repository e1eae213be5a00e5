"""A second sensor: what moves one of the two alone is told, beside each interface."""

import pytest
from fault_machines import judged, site_of
from rig.specs import changed, controller_of

from heatwright.sim.faults import starts

DS18B20 = "{{kind: ds18b20, pin: {}, resolution: 9 bit}}"
THERMISTOR = (
    "{{kind: thermistor, pin: {}, divider: {{pull_up: 4.7 kΩ}}, curve: {{resistance: 100 kΩ, "
    "at: 25 °C, beta: 4267 K}}, range: 0 °C .. 300 °C, oversample: 4}}"
)


def doubled(example: str, second: str, place: str, limits: str, agreement: str) -> str:
    """Give a machine's first loop a second sensor; place -- in the plant."""
    sensor, _, loop = example.partition(":")
    name = next(iter(controller_of(sensor).loops))
    spec = controller_of(sensor).loops[name]
    rules = f"stale_after: {spec.protection.stale_after_s:g} s"
    return changed(
        sensor,
        ("\nsensors:\n", f"\nsensors:\n  twin: {second}\n"),
        (f"    sensor: {loop or spec.sensor}\n", f"    sensor: {spec.sensor}\n    also: twin\n"),
        (rules, f"{rules}\n      agreement: {agreement}"),
        ("\nsafety:", f"\nmonitors: {{twin: {{sensor: twin, {limits}}}}}\n\nsafety:"),
        ("    sense: {", f"    sense: {{twin: {place}, "),
    )


MACHINES = {
    "chamber": doubled(
        "chamber", DS18B20.format("A2"), "{node: air, lag: 10 s}",
        "warning: 80 °C, limit: 90 °C", "{within: 6 K, for: 20 s}",
    ),
    "extruder": doubled(
        "extruder", THERMISTOR.format("A14"), "{node: block, lag: 2 s}",
        "warning: 280 °C, limit: 295 °C, hysteresis: 6 K", "{within: 15 K, for: 5 s}",
    ),
}  # fmt: skip

TOLD_BY_HEAT = {("chamber", "sensor_drifts_low"), ("chamber", "sensor_creeps_out")}
"""It warms its air so slowly that a reading that falls meanwhile does not rise at full power."""


@pytest.mark.parametrize("machine", MACHINES)
@pytest.mark.parametrize(
    "fault", ["sensor_drifts_low", "second_sensor_drifts_low", "sensor_creeps_out"]
)
def test_one_that_lies_plausibly_is_told(machine: str, fault: str) -> None:
    rule = "heating_failed" if (machine, fault) in TOLD_BY_HEAT else "sensors_disagree"
    assert judged(MACHINES[machine], fault) == rule


@pytest.mark.parametrize("machine", MACHINES)
@pytest.mark.parametrize("fault", ["monitor_twin_torn", "monitor_twin_shorted", "small_jumps"])
def test_the_second_one_s_own_faults(machine: str, fault: str) -> None:
    judged(MACHINES[machine], fault)


def test_without_a_reading_of_the_second_nothing_heats() -> None:
    world = starts.heating(site_of(MACHINES["chamber"]))
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
