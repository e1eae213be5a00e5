"""Programs, displays, logs, relays and types of thermocouples: attributes, defaults, words."""

import re
from pathlib import Path
from typing import Any

import pytest

from heatwright.spec import (
    AfterPowerLoss,
    ComparisonRow,
    Controller,
    HoldBack,
    Max31856,
    Nextion,
    Pid,
    Program,
    ProgramOrder,
    Programs,
    Radiation,
    Runaway,
    Segment,
    Sensor,
    SerialLog,
    SpecError,
    TimeProportionalOutput,
    commanded,
    kinds,
    load,
    load_text,
    must_release,
    nextion_of,
    programmed,
    row_controller,
    starts_enabled,
    switched,
    tunable,
)
from heatwright.spec.commands import zero_is_off
from heatwright.spec.max31856 import RANGE_C
from heatwright.spec.uses import pin_uses, uart_of

EXAMPLES = Path(__file__).parents[2] / "spec" / "examples"
KILN = (EXAMPLES / "kiln.yaml").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def kiln() -> Controller:
    return load(EXAMPLES / "kiln.yaml").controller


def changed(*pairs: tuple[str, str]) -> Controller:
    """The kiln with some of its text replaced."""
    text = KILN
    for old, new in pairs:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return load_text(text).controller


def programs(**keys: Any) -> Programs:
    return Programs.model_validate({"loop": "chamber", **keys})


def test_the_kilns_programs(kiln: Controller) -> None:
    found = kiln.programs
    assert found is not None
    assert (found.loop, found.points, found.places) == ("chamber", 10, 3)
    assert found.hold_back is not None
    assert found.hold_back.within_k == 10.0
    after = found.after_power_loss
    assert (after.resume_within_k, after.otherwise) == (30.0, "stop")
    (fuse,) = found.stored
    assert fuse.name == "fuse"
    assert [each.kind for each in fuse.segments] == [
        "over", "hold", "over", "hold", "over", "hold", "over",
    ]  # fmt: skip
    assert (fuse.segments[0].to_c, fuse.segments[0].over_s) == (540.0, 3600.0)
    assert (fuse.segments[1].to_c, fuse.segments[1].hold_s) == (None, 1800.0)


def test_the_defaults_of_programs() -> None:
    found = programs()
    assert (found.points, found.places, found.stored) == (10, 3, ())
    assert (found.reached_within_k, found.save_every_s, found.at_end) == (1.0, 60.0, "off")
    assert found.hold_back == HoldBack.model_validate({})
    assert found.hold_back is not None
    assert (found.hold_back.within_k, found.hold_back.limit_s) == (8.0, 7200.0)
    assert found.after_power_loss == AfterPowerLoss.model_validate({})
    assert (found.after_power_loss.resume_within_k, found.after_power_loss.otherwise) == (0, "stop")


def test_the_default_clock_waits_before_the_default_runaway() -> None:
    within_k = HoldBack.model_validate({}).within_k
    assert within_k < Runaway.model_validate({}).above_k


def test_as_many_places_as_are_stored() -> None:
    stored = [{"name": str(i), "segments": ({"hold": "1 h"},)} for i in range(5)]
    assert programs(stored=tuple(stored)).places == 5
    assert programs(stored=tuple(stored), places=7).places == 7
    assert programs(places=1).places == 1


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        ("5 K", (5.0, 7200.0)),
        ({"within": "5 K"}, (5.0, 7200.0)),
        ({"limit": "30 min"}, (8.0, 1800.0)),
        ({"within": "5 K", "limit": "30 min"}, (5.0, 1800.0)),
        ("off", None),
    ],
)
def test_ways_to_hold_back(written: object, expected: tuple[float, float] | None) -> None:
    found = programs(hold_back=written).hold_back
    assert (found and (found.within_k, found.limit_s)) == expected


def test_a_program_never_resumes_unless_told() -> None:
    stops = programs(after_power_loss="stop").after_power_loss
    assert (stops.resume_within_k, stops.otherwise) == (0.0, "stop")


@pytest.mark.parametrize(
    ("written", "kind", "values"),
    [
        ({"to": "540 °C", "over": "60 min"}, "over", (540.0, 3600.0, None, None)),
        ({"to": "540 °C", "at": "150 K/h"}, "rate", (540.0, None, 150.0, None)),
        ({"to": "540 °C", "at": "2.5 K/min"}, "rate", (540.0, None, 150.0, None)),
        ({"to": "540 °C", "at": "as fast as possible"}, "fast", (540.0, None, None, None)),
        ({"hold": "30 min"}, "hold", (None, None, None, 1800.0)),
        ({"hold": "until operator"}, "until", (None, None, None, None)),
    ],
)
def test_the_forms_of_a_segment(
    written: dict[str, str], kind: str, values: tuple[float | None, ...]
) -> None:
    segment = Segment.model_validate(written)
    assert segment.kind == kind
    assert (segment.to_c, segment.over_s, segment.at_k_per_h, segment.hold_s) == values
    assert (segment.fast, segment.until) == (kind == "fast", kind == "until")


def test_a_name_fits_a_display() -> None:
    hold = ({"hold": "1 h"},)
    assert Program.model_validate({"name": "123456789012", "segments": hold}).name
    with pytest.raises(ValueError, match="1 to 12 plain characters"):
        Program.model_validate({"name": "1234567890123", "segments": hold})


@pytest.mark.parametrize(
    ("written", "order"),
    [
        ("start 1", ProgramOrder("start", 1)),
        ("pause", ProgramOrder("pause")),
        ("resume", ProgramOrder("resume", 0)),
        ("skip", ProgramOrder("skip", 0)),
        ("jump 7", ProgramOrder("jump", 7)),
        ("stop", ProgramOrder("stop", 0)),
    ],
)
def test_orders(written: str, order: ProgramOrder) -> None:
    controller = changed(
        ("    - {for: 8 h}", f"    - {{at: 9 s, program: {written}}}\n    - {{for: 8 h}}")
    )
    assert controller.simulation is not None
    assert controller.simulation.scenario[1].program == order


def test_what_is_sent_may_have_filled_a_place() -> None:
    sent = ('{at: 5 s, send: "#8 1;"}', '{at: 5 s, send: "#13 2;"}')
    started = ("    - {for: 8 h}", "    - {at: 9 s, program: start 2}\n    - {for: 8 h}")
    assert changed(sent, started)
    text = KILN.replace(sent[0], "{at: 5 s, program: start 1}").replace(*started)
    with pytest.raises(SpecError, match="program 2 is empty"):
        load_text(text)


def test_a_programmed_loop_is_switched_by_people(kiln: Controller) -> None:
    assert programmed(kiln, "chamber")
    assert switched(kiln, "chamber")
    assert commanded(kiln, "chamber")
    assert tunable(kiln, "chamber")
    assert not zero_is_off(kiln, "chamber")
    assert not must_release(kiln)
    assert not starts_enabled(kiln, "chamber")
    assert not programmed(kiln, "lid")
    assert not switched(kiln, "lid")
    assert starts_enabled(
        changed(("    period: 1 s", "    starts: enabled\n    period: 1 s")), "chamber"
    )


def test_a_row_of_a_comparison_needs_no_operator(kiln: Controller) -> None:
    row = ComparisonRow.model_validate(
        {"name": "P", "setpoint": "300 °C", "algorithm": {"kind": "pid", "kp": 5, "ki": 0.01}}
    )
    assert starts_enabled(row_controller(kiln, row), "chamber")


def test_a_display_beside_a_master_leaves_the_loop_off() -> None:
    """The master has all loops; the one that people switch is still off until somebody does."""
    text = re.sub(r"(?ms)^programs:.*?(?=^safety:)", "", KILN)
    text = text.replace("      feed_forward", "      # feed_forward")
    text = text.replace(
        "  - {kind: serial_log, loop: chamber, port: 1", "  - {kind: modbus_rtu}\n  # -"
    )
    text = text.replace("115200, loop: chamber}", "115200, loop: chamber, port: 2}")
    text = text.replace(", tracking: 1 K", "")
    controller = load_text(text).controller
    assert must_release(controller)
    assert switched(controller, "chamber")
    assert not starts_enabled(controller, "chamber")


@pytest.mark.parametrize(
    ("example", "enabled", "releases"),
    [("chamber", True, False), ("feeder", True, False), ("fabricator", False, True)],
)
def test_others_start_as_before(example: str, enabled: bool, releases: bool) -> None:
    controller = load(EXAMPLES / f"{example}.yaml").controller
    name = next(iter(controller.loops))
    assert starts_enabled(controller, name) == enabled
    assert must_release(controller) == releases
    assert nextion_of(controller) is None
    assert not programmed(controller, name)


def test_the_thermocouple(kiln: Controller) -> None:
    sensor = kiln.sensors["chamber"]
    assert isinstance(sensor, Max31856)
    assert (sensor.thermocouple, sensor.selectable, sensor.average) == ("K", ("K", "S"), 2)
    assert (sensor.mains_filter_hz, sensor.moving_average) == (50.0, 5)
    assert sensor.step_k == 1 / 128
    plain = Max31856.model_validate(
        {"kind": "max31856", "chip_select": "D1", "clock": "D2", "data_in": "D3", "data_out": "D4"}
    )
    assert (plain.thermocouple, plain.selectable, plain.average) == ("K", (), 1)
    assert (plain.mains_filter_hz, plain.moving_average) == (50.0, 1)


@pytest.mark.parametrize("kind", RANGE_C)
def test_every_type_has_its_range(kind: str) -> None:
    text = KILN.replace("thermocouple: K", f"thermocouple: {kind}")
    lowest_c, highest_c = RANGE_C[kind]
    words = []
    if lowest_c > -10:
        words.append("-10 °C may never be read")
    if highest_c < 1150 + 5:
        words.append("1150 °C may never be read")
    text = text.replace(
        "    selectable: [K, S]", f"    selectable: [{kind}, {'R' if kind == 'S' else 'S'}]"
    )
    if not words:
        assert load_text(text)
        return
    with pytest.raises(SpecError) as caught:
        load_text(text)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize("kind", [kind for kind in kinds(Sensor) if kind != "current"])
def test_every_thermometer_can_be_averaged(kind: str) -> None:
    assert kinds(Sensor)[kind].model_fields["moving_average"].default == 1


def test_the_relay_and_its_contact(kiln: Controller) -> None:
    assert (kiln.safety.relay, kiln.safety.relay_feedback) == ("safety_relay", "D9")
    used = {use.path: use.pin.name for use in pin_uses(kiln)}
    assert used["safety", "relay_feedback"] == "D9"
    assert used["outputs", "safety_relay", "pin"] == "D8"


def test_interfaces_have_their_ports(kiln: Controller) -> None:
    display, log = kiln.interfaces
    assert isinstance(display, Nextion)
    assert isinstance(log, SerialLog)
    assert nextion_of(kiln) is display
    assert (display.loop, display.baud, display.port) == ("chamber", 115_200, 0)
    assert (log.port, log.every_s, log.keep) == (1, 60.0, "ram")
    first, second = uart_of(kiln.board, display), uart_of(kiln.board, log)
    assert first is not None
    assert second is not None
    assert (first.number, second.number) == (0, 1)
    used = {use.pin.name: use.path for use in pin_uses(kiln) if use.purpose == "the serial port"}
    assert used == dict.fromkeys(("D0", "D1"), ("interfaces", 0)) | dict.fromkeys(
        ("D18", "D19"), ("interfaces", 1)
    )


def test_the_defaults_of_a_display_and_a_log() -> None:
    display = Nextion.model_validate({"kind": "nextion", "loop": "air"})
    assert (display.baud, display.port) == (115_200, 0)
    log = SerialLog.model_validate({"kind": "serial_log", "loop": "air"})
    assert (log.baud, log.port, log.every_s, log.entries, log.keep) == (115_200, 0, 60, 480, "ram")


def test_the_rest_of_the_kiln(kiln: Controller) -> None:
    loop = kiln.loops["chamber"]
    assert isinstance(loop.algorithm, Pid)
    assert loop.algorithm.feed_forward > 0
    assert loop.protection.maximum_adjustable
    assert loop.starts is None
    element = kiln.outputs["element"]
    assert isinstance(element, TimeProportionalOutput)
    assert element.distribution == "burst"
    assert kiln.simulation is not None
    assert kiln.simulation.plant.radiation == (
        Radiation.model_validate(
            {"between": ("brick", "ambient"), "area": "50 cm²", "emissivity": 0.3}
        ),
    )
