"""What is monitored, beside each interface: its sensor breaks, it is too warm, people are told."""

from functools import cache

import pytest
from fault_machines import faults_of, judged
from rig.specs import changed

from heatwright.sim.faults.machine_parts.monitors import untold

THERMISTOR = (
    "{kind: thermistor, pin: PIN, divider: {pull_up: 4.7 kΩ}, curve: {resistance: 100 kΩ, "
    "at: 25 °C, beta: 3950 K}, range: 0 °C .. 150 °C, oversample: 2}"
)
DS18B20 = "{kind: ds18b20, pin: PIN, resolution: 9 bit}"
MONITORS = """monitors:
  lamp: {sensor: lamp, warning: 100 °C, limit: 110 °C, stale_after: 20 s}
  drivers_of_motors: {sensor: box, warning: 60 °C, limit: 80 °C}

"""
EXAMPLES = {
    "chamber": (DS18B20, "A2", "A3", 1),
    "kiln": (DS18B20, "A4", "A5", 2),
    "kiln_uno": (DS18B20, "A3", "A4", 2),
    "extruder": (THERMISTOR, "A3", "A4", 1),
    "fabricator": (THERMISTOR, "PA4", "PA5", 1),
}
"""A panel, a touch display with a log, a menu, a host, a master: the lamp's sensor, its pin and the
other's, and how many tell of warnings."""
RULES = {
    DS18B20: {"torn": "sensor_no_answer", "shorted": "sensor_short"},
    THERMISTOR: {"torn": "sensor_open", "shorted": "sensor_short"},
}


@cache
def monitored(example: str) -> str:
    lamp, *pins, _ = EXAMPLES[example]
    kinds = {"lamp": (lamp, pins[0]), "box": (THERMISTOR, pins[1])}
    sensors = [f"  {name}: {kind.replace('PIN', pin)}\n" for name, (kind, pin) in kinds.items()]
    places = "lamp: {node: box}, box: {node: box, lag: 5 s}, "
    text = changed(
        example,
        ("\nsensors:\n", "\nsensors:\n" + "".join(sensors)),
        ("\nsafety:", f"\n{MONITORS}safety:"),
        ("    sense: {", f"    sense: {{{places}"),
        ("    links:", "    LINKS:"),
    )
    link = "    links:\n      - {between: [box, ambient], resistance: 3 K/W}\n"
    text = text.replace("    LINKS:", link.rstrip("\n"))
    if "    nodes: {" in text:
        return text.replace("    nodes: {", "    nodes: {box: 300 J/K, ")
    return text.replace("      air: 900 J/K", "      air: 900 J/K\n      box: 300 J/K")


CASES = [
    (example, f"monitor_{name}_{what}", rule)
    for example, (lamp, *_) in EXAMPLES.items()
    for name, kind in (("lamp", lamp), ("drivers_of_motors", THERMISTOR))
    for what, rule in {**RULES[kind], "over_limit": "monitor_limit", "warns": None}.items()
]


@pytest.mark.parametrize(("example", "name", "rule"), CASES)
def test_it_trips_its_rule_or_warns(example: str, name: str, rule: str | None) -> None:
    assert judged(monitored(example), name) == rule


@pytest.mark.parametrize("example", EXAMPLES)
def test_who_is_not_told_is_found(example: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where RAM alone had a warning, each interface would lack it."""
    world = faults_of(monitored(example))["monitor_lamp_warns"].make()
    read = world.device.read
    monkeypatch.setattr(world.device, "read", lambda name: "warns" in name or read(name))
    assert len(list(untold(world))) == EXAMPLES[example][-1]


@pytest.mark.parametrize("fault", ["switch_shorted_when_hot", "fire"])
def test_a_monitor_that_trips_below_the_loops_maximum_lets_each_fault_begin(fault: str) -> None:
    text = changed(
        "chamber",
        ("\nsensors:\n", f"\nsensors:\n  outlet: {DS18B20.replace('PIN', 'A2')}\n"),
        (
            "\nsafety:",
            "\nmonitors:\n  outlet: {sensor: outlet, warning: 74 °C, limit: 78 °C}\n\nsafety:",
        ),
        ("    sense: {", "    sense: {outlet: {node: air, lag: 5 s}, "),
    )
    assert judged(text, fault) == "monitor_limit"
