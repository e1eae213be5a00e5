"""What a project's README has people do, know and wire."""

import re
from dataclasses import replace
from itertools import chain, combinations
from typing import Any, NamedTuple
from xml.etree import ElementTree as ET

import pytest
from rig.controllers import drawn
from rig.firmware import EXAMPLE_NAMES, changed, example, files_of, spec_of
from suite import amount

from heatwright.generator import plan_firmware
from heatwright.generator.plan.documents.commissioning import Stage, Step
from heatwright.generator.plan.parts import Symbol
from heatwright.generator.plan.protection.hazards import hazards, within
from heatwright.generator.plan.protection.limits import limit
from heatwright.generator.wiring import drawn as wires
from heatwright.sim.circuits.ports import pin_v
from heatwright.sim.faults import bounds
from heatwright.spec import Loop, Spec, facts_of
from heatwright.spec.rules import RULES


def stages(spec: Spec) -> list[Stage]:
    files = {file.path: file.told for file in plan_firmware(spec).files}
    found: list[Stage] = files["README.md"].commissioning
    return found


def steps(spec: Spec) -> dict[str, str]:
    return {step.do: step.see for step in chain(*(stage.steps for stage in stages(spec)))}


def seen(spec: Spec, start: str) -> str:
    (found,) = (see for do, see in steps(spec).items() if do.startswith(start))
    return found


@pytest.mark.parametrize("name", EXAMPLE_NAMES)
def test_the_voltage_at_a_pin_is_the_simulations(name: str) -> None:
    controller = example(name).controller
    for sensor in controller.adc_sensors.values():
        if sensor.measures_current:
            continue
        pin = controller.board.pins[sensor.pin].name
        (told,) = re.findall(r"about ([\d.]+) V", seen(example(name), f"Measure {pin}"))
        assert float(told) == pytest.approx(float(pin_v(sensor, 20.0)), rel=5e-3)


@pytest.mark.parametrize("name", EXAMPLE_NAMES)
def test_a_torn_sensor_is_told_as_soon_as_the_hazards_say(name: str) -> None:
    """A test holds these to the simulation."""
    readme = files_of(name)["README.md"]
    (row,) = re.findall(r"^\| The sensor is torn.*", readme, re.MULTILINE)
    latest = max(float(each) for each in re.findall(r"E\d\d ([\d.]+) s", row))
    pulled = [see for do, see in steps(example(name)).items() if do.endswith("the sensor's plug")]
    told = [float(re.findall(r"within ([\d.]+) s", see)[0]) for see in pulled]
    assert max(told) == pytest.approx(latest, rel=5e-3)


def test_a_heater_has_the_resistance_of_its_power() -> None:
    assert seen(example("fabricator"), "Measure heater") == "8.54 Ω ± 10 %"
    assert seen(example("kiln"), "Measure heater").endswith("109 Ω at 230 V (± 10 %)")


def test_the_level_of_rest_is_that_at_which_nothing_conducts() -> None:
    """The kiln's triac is lit by a low pin."""
    held = "Hold the reset button, and let it go: measure "
    assert seen(example("kiln"), f"{held}D2 = PE4") == "5 V all the time"
    assert seen(example("chamber"), f"{held}D3 = PD3") == "0 V all the time"
    assert not [do for do in steps(example("chamber")) if "`fan`)" in do], "it runs always"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("chamber", "`air` is on again, at 20 °C"),
        (changed("chamber", ("maximum: 70 °C}", "maximum: 70 °C, stored: true}")), "of before"),
        ("kiln", "`chamber` is off until somebody switches it on"),
        ("extruder", "`nozzle` is off until somebody switches it on"),
    ],
)
def test_what_comes_back_with_the_power_is_told(text: str, told: str) -> None:
    spec = spec_of(text) if "\n" in text else example(text)
    assert seen(spec, "Take all power away").endswith(told)


def test_the_loads_have_no_power_before_all_that_switches_them_off_was_seen() -> None:
    random = (each.spec for each in drawn(amount("drawn_models")))
    for spec in (*map(example, EXAMPLE_NAMES), *random):
        found = stages(spec)
        assert [stage.title.partition(":")[0] for stage in found] == [
            "Nothing has power", "The board has power, the loads have none",
            "A lamp in the place of each heater", "The first heating",
        ]  # fmt: skip
        assert all(isinstance(step, Step) and step.see for stage in found for step in stage.steps)
        for loop in spec.controller.loops.values():
            assert any(f"`{loop.heater}`" in step.do for step in found[0].steps)
            assert any(f"`{loop.heater}`" in step.do for step in found[1].steps)


RULES_BY_ID = {rule.id: rule for rule in RULES.values()}


UNCHECKED = ("safety:", "safety:\n  self_checks: false")
TEXTS = {name: changed(name) for name in EXAMPLE_NAMES} | {
    f"{name} unchecked": changed(name, UNCHECKED) for name in ("chamber", "extruder")
}


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_each_rule_is_told_for_some_hazard_and_with_what_trips_it(text: str) -> None:
    spec = spec_of(text)
    told = " ".join(row.seen for row in hazards(spec.controller))
    rules = facts_of(spec.controller).rules
    codes = {f"E{rule.code:02d}" for rule in rules}
    assert {word for word in told.split() if word.startswith("E")} == codes
    assert [rule.id for rule in rules if limit(spec, rule.id) == "not used here"] == []


def bound_s(loop: Loop, rule: str) -> float:
    """Return the bound that `verify` holds a rule to, from the cause to heater off."""
    protection = loop.protection
    if rule.startswith("sensor_") and rule != "sensor_frozen":
        return bounds.answer_s(loop)
    if rule == "heating_failed":
        assert protection.heating is not None
        return bounds.lasting_s(protection.heating.within_s, loop)
    if rule == "runaway_above":
        assert protection.runaway is not None
        return bounds.lasting_s(protection.runaway.for_s, loop)
    return bounds.reading_s(loop)


@pytest.mark.parametrize("name", EXAMPLE_NAMES)
def test_the_times_are_those_that_verify_holds(name: str) -> None:
    controller = example(name).controller
    for rule in ("sensor_crc", "over_temperature", "rise_rate", "heating_failed", "runaway_above"):
        if RULES_BY_ID[rule] in facts_of(controller).rules:
            slowest_s = max(bound_s(loop, rule) for loop in controller.loops.values())
            assert within(controller, RULES_BY_ID[rule]) == f"{round(slowest_s, 2):g} s", rule
    hangs = f"{bounds.gate_s():g} s, with interrupts off the watchdog's "
    hangs += f"{controller.safety.watchdog_s:g} s"
    assert within(controller, RULES_BY_ID["watchdog_reset"]) == hangs


def test_what_no_rule_sees_is_told() -> None:
    """The chamber has a fan without a proof, and no safety relay."""
    rows = {row.cause: row for row in hazards(example("chamber").controller)}
    assert rows["A fan that a heater needs stands still"].seen == "nothing"
    assert "only the thermal fuse" in rows["A heater's switch conducts permanently"].remains
    drift = "The sensor drifts, creeps out of its place, or is of another kind"
    for name, above in (("extruder", "nozzle above 146 °C"), ("kiln", "chamber above 620 °C")):
        told = {row.cause: row.remains for row in hazards(example(name).controller)}[drift]
        assert f"of {above} no rule detects a reading that is too low" in told


def test_a_current_beside_a_ds18b20_brings_no_rule_of_what_a_thermometer_on_the_adc_reads() -> None:
    """What its sensor says is judged by the heater: codes 20 to 22."""
    current = ("power: 240 W", "power: 240 W, supply: 24 V, current: {sensor: amps, trip: 15 A}")
    amps = ("\noutputs:", "\n  amps: {kind: current, pin: A2, scale: 0.2 V/A}\n\noutputs:")
    sense = ("sense: {air:", "sense: {amps: {of: heater}, air:")
    text = changed("chamber", amps, current, sense)
    codes = {rule.code for rule in facts_of(spec_of(text).controller).rules}
    assert {20, 21, 22} <= codes
    assert codes.isdisjoint((17, 18))


@pytest.mark.parametrize(
    ("pulses", "within_s"),
    [
        ("window: 1 s, resolution: 10 ms", 3.04),
        ("window: 1 s, resolution: 10 ms, minimum_on: 100 ms", 3.04),
        ("window: 1 s, resolution: 10 ms, minimum_on: 100 ms, minimum_off: 20 ms", 2.04),
        ("window: 2 s, resolution: 20 ms", 4.04),
        ("window: 2 s, resolution: 20 ms, distribution: spread", 4.04),
    ],
)
def test_a_pin_that_is_held_is_seen_once_three_looks_asked_for_the_other_level(
    pulses: str, within_s: float
) -> None:
    """One that is held on, in the pauses: at nearly full power each window has one of a step."""
    text = changed("kiln", ("window: 1 s, resolution: 10 ms", pulses))
    assert within(spec_of(text).controller, RULES_BY_ID["pin_held"]) == f"{within_s} s"


ADAPTER = "an adapter with levels of 5 V: its TXD to {}, its RXD to {}, ground to ground"
SOCKET = "none: the board's USB socket is this line"
MAX232 = "a converter for 5 V, such as a MAX232: R1OUT to {}, T1IN to {}"
MAX485 = (
    "a transceiver for 5 V, such as a MAX485: RO to {}, DI to {}, DE and /RE to {}; "
    "120 Ω between A and B at both ends of the bus, bias at one end"
)
BARE_PINS = "PD0", "PD1"
NANO_PINS = "D0 = PD0", "D1 = PD1"
FAST = changed("feeder", ("kind: gcode, baud: 115200", "kind: gcode, baud: 250000"))
LEONARDO = changed("barrel", ("board: uno", "board: leonardo"), (", driver_enable: D2", ""))


@pytest.mark.parametrize(
    ("spec", "expected"),
    [
        ("fabricator", {
            ("Modbus, 19200 baud, 8E1", "USB"): ADAPTER.format(*BARE_PINS),
            ("Modbus, 19200 baud, 8E1", "RS-232"): MAX232.format(*BARE_PINS),
            ("Modbus, 19200 baud, 8E1", "RS-485"): (
                "a transceiver, and a pin that switches it: `driver_enable` in the spec"
            ),
        }),
        ("dryer", {("Modbus, 38400 baud, 8O1", "RS-485"): MAX485.format(*BARE_PINS, "PD2")}),
        ("feeder", {
            ("G-code, 115200 baud, 8N1", "USB"): SOCKET,
            ("G-code, 115200 baud, 8N1", "RS-232"): MAX232.format(*NANO_PINS),
        }),
        (FAST, {
            ("G-code, 250000 baud, 8N1", "USB"): SOCKET,
            ("G-code, 250000 baud, 8N1", "RS-232"): (
                "too fast for RS-232: a MAX232 reaches 120000 baud"
            ),
        }),
        ("oven", {
            ("serial plotter, 9600 baud, 8N1", "USB"): SOCKET,
            ("serial plotter, 9600 baud, 8N1", "RS-232"): (
                "a converter for 5 V, such as a MAX232: T1IN to D1 = PD1"
            ),
        }),
        ("kiln", {
            ("serial log, 115200 baud, 8N1", "USB"): ADAPTER.format("D19 = PD2", "D18 = PD3"),
            ("serial log, 115200 baud, 8N1", "RS-232"): MAX232.format("D19 = PD2", "D18 = PD3"),
        }),
    ],
)  # fmt: skip
def test_each_line_has_its_level_converters(spec: str, expected: dict[Any, str]) -> None:
    rows = re.findall(r"^\| (.+) \| (USB|RS-232|RS-485) \| (.+) \|$", readme(spec), re.MULTILINE)
    assert {(line, to): needs for line, to, needs in rows} == expected
    assert len(rows) == len(expected)


def test_a_leonardos_socket_is_no_line_and_without_one_there_is_no_such_page() -> None:
    """Its serial port is on pins alone, and no bootloader speaks there."""
    assert f"| USB | {ADAPTER.format('D0 = PD2', 'D1 = PD3')} |" in readme(LEONARDO)
    plotter = "interfaces:\n  - {kind: serial_plotter, loop: air, baud: 9600}\n"
    without = changed("incubator", (plotter, ""))
    assert "Levels of the lines" in readme("incubator")
    assert "Levels of the lines" not in readme(without)


def readme(spec: str) -> str:
    return files_of(spec)["README.md"]


SVG = "{http://www.w3.org/2000/svg}"
NARROW = 0.5
"""Width of a character, at least, in heights: of DejaVu Sans, the widest that browsers take."""


class Text(NamedTuple):
    """A piece of text and the box it stands in, in points."""

    words: str
    left: float
    top: float
    right: float
    bottom: float


def texts(svg: str) -> list[Text]:
    found = []
    for each in ET.fromstring(svg).iter(f"{SVG}text"):  # noqa: S314 - our own
        words = "".join(each.itertext()).strip()
        height = float(each.get("font-size", "0").removesuffix("px").removesuffix("pt"))
        width = len(words) * height * NARROW
        left = float(each.get("x", "0"))
        left -= {"middle": width / 2, "end": width}.get(each.get("text-anchor", ""), 0.0)
        bottom = float(each.get("y", "0"))
        bottom += 0.35 * height * (each.get("dominant-baseline") == "central")
        found.append(Text(words, left, bottom - 0.7 * height, left + width, bottom))
    return found


def overlapping(found: list[Text]) -> list[tuple[str, str]]:
    return [
        (a.words, b.words)
        for a, b in combinations(found, 2)
        if a.left < b.right and b.left < a.right and a.top < b.bottom and b.top < a.bottom
    ]


def pins(spec: Spec) -> set[str]:
    """Return the pins that the firmware has functions for, and those in the table of the README."""
    files = {file.path: file.told for file in plan_firmware(spec).files}
    used = {pin.label.partition(" = ")[0] for pin in files["src/pins.h"].pins}
    told = {word for row in files["README.md"].wiring for word in row.pin.split()}
    assert used <= told, "a pin is missing in the README's table"
    return used


@pytest.mark.parametrize("name", EXAMPLE_NAMES)
def test_every_pin_is_drawn_and_no_text_stands_on_another(name: str) -> None:
    svg = files_of(name)["wiring.svg"]
    found = texts(svg)
    assert pins(example(name)) <= {word for text in found for word in text.words.split()}
    assert overlapping(found) == []
    left, _, width, _ = map(float, ET.fromstring(svg).attrib["viewBox"].split())  # noqa: S314
    assert max(each.right for each in found) <= left + width, "a text is cut off"
    assert "](wiring.svg)" in readme(name)


def test_overlapping_text_would_be_seen() -> None:
    svg = f'<svg xmlns="{SVG[1:-1]}"><text x="0" y="9" font-size="10">abc</text>{{}}</svg>'
    other = '<text x="{}" y="9" font-size="10">def</text>'
    assert overlapping(texts(svg.format(other.format(14)))) == [("abc", "def")]
    assert overlapping(texts(svg.format(other.format(16)))) == []


def test_every_pin_of_drawn_controllers_is_in_the_table() -> None:
    for each in drawn(amount("drawn_models")):
        pins(each.spec)


def test_a_contact_that_is_closed_while_all_is_well_is_drawn_closed() -> None:
    rows = [row for rows in plan_firmware(example("kiln")).wiring.values() for row in rows]
    (mirror,) = (row for row in rows if row.how.startswith("its mirror contact"))
    assert [symbol.shape for symbol in mirror.symbols] == ["closed"]
    symbol = Symbol("down", "contact", "mirror contact, normally closed")
    opened = replace(mirror, symbols=(symbol,))
    assert wires("kiln", "mega2560", [mirror]) != wires("kiln", "mega2560", [opened])
