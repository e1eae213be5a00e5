"""Faults of one loop where another, quicker or with the keys, is beside it."""

import pytest
from fault_machines import faults_of, judged
from rig.specs import changed

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
