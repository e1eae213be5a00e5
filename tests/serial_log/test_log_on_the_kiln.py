"""The log in the kilns' whole firmware: it tells what the loop did, and changes nothing of it."""

import random
import re
import time
from typing import Any

import numpy as np
import pytest
from rig.firmware import ROOT, changed, example, spec_of, whole
from rig.live import simulated
from test_serial_log import shown_c

from heatwright.sim.bench import bench
from heatwright.sim.device import AvrDevice
from heatwright.sim.interfaces.serial_log import PROGRAMMED
from heatwright.sim.replay import replay
from heatwright.sim.trace import StepLog
from heatwright.spec import Controller, Event, SerialLog

KILNS = ("kiln", "kiln_uno")
FLOOD_S = 60
SPEED = 60  # times real time: an entry a minute comes every second


def fired(
    controller: Controller, device: AvrDevice, duration: str, *stops: dict[str, str]
) -> StepLog:
    events = [{"at": "5 s", "program": "start 1"}, *stops, {"for": duration}]
    trace = bench(controller, device, [Event.model_validate(event) for event in events])
    return trace.steps["chamber"]


def told(device: AvrDevice, command: str) -> list[str]:
    device.log_reader.write(command)
    device.advance(device.time_s + 2)
    device.feed()
    return device.log_reader.texts


def times_told(device: AvrDevice) -> list[int]:
    assert told(device, "log")
    return [row.time_s for row in device.log_reader.rows]


@pytest.mark.parametrize("name", KILNS)
def test_it_tells_what_the_loop_did(name: str) -> None:
    controller = example(name).controller
    device = AvrDevice(controller, whole(name))
    # The step of the 40th minute comes later than that by the time that the start takes.
    steps = fired(controller, device, "2402 s", {"at": "39 min", "program": "stop"})
    (log,) = (each for each in controller.interfaces if isinstance(each, SerialLog))
    every_s = round(log.every_s)
    assert times_told(device) == list(range(every_s, 40 * 60 + 1, every_s))
    assert device.log_reader.is_complete
    for row in device.log_reader.rows:
        (step,) = steps[steps["steps"] == row.time_s]  # of the same tick: its period is a second
        assert row.temperature_c == shown_c(float(step["temperature_c"]))
        assert row.setpoint_c == shown_c(float(step["setpoint_c"]))
        assert row.duty_percent == int(float(step["duty_percent"]) + 0.5)
        place = (step["program.number"], step["program.segment"])
        assert (row.program, row.segment) == (place if step["program.state"] else (None, None))
    assert {row.program for row in device.log_reader.rows} == {1, None}
    assert len({row.duty_percent for row in device.log_reader.rows}) > 3
    assert max(row.setpoint_c for row in device.log_reader.rows) > 150
    assert controller.programs is not None
    saves = told(device, "saves")
    assert saves == [str(device.read("progress.c:newest.sequence"))]
    assert int(saves[0]) >= 39 * 60 // controller.programs.save_every_s
    known = "log, clear, saves, response" if name == "kiln" else "log, clear, saves"
    assert told(device, "save") == [f"unknown: write {known} or help"]


def test_it_tells_how_the_loop_answered() -> None:
    """To the hold behind a ramp: what the reference measures, and what the course itself says."""
    text = changed(
        "kiln",
        ("{to: 540 °C, over: 60 min}", "{to: 60 °C, over: 2 min}"),
        ("response: {within: 3 K, for: 5 min}", "response: {within: 0.5 K, for: 1 min}"),
    )
    controller = spec_of(text).controller
    device = AvrDevice(controller, whole(text))
    heading = "measured,settling_s,overshoot_k"
    device.advance(1.0)  # what comes before the line is set up is lost
    assert told(device, "response") == [heading, "0,0.0,0.0"]
    steps = fired(controller, device, "20 min")
    assert not replay(controller, steps, "chamber").mismatches
    held = steps[steps["setpoint_c"] == 60]
    error_k = held["temperature_c"].astype(float) - 60
    near = np.abs(error_k) <= 0.5
    entered = next(n for n in range(len(near)) if near[n : n + 61].all())
    over_k = max(0.0, error_k[: entered + 61].max())
    assert entered > 5
    assert told(device, "response") == [heading, f"1,{entered}.0,{over_k + 1e-9:.1f}"]


@pytest.mark.parametrize("name", KILNS)
def test_a_flood_changes_nothing_of_the_control(name: str) -> None:
    controller = example(name).controller
    quiet, flooded = (AvrDevice(controller, whole(name)) for _ in range(2))
    drawn = random.Random(1)  # noqa: S311 - no secret
    words = b"log\n clear\n help\n \r\n \0 \xff".split(b" ")
    noise = b"".join(drawn.choices([*words, *(bytes([n]) for n in range(256))], k=11_520 * FLOOD_S))
    flooded.log_reader.send_bytes(noise[: 11_520 * FLOOD_S])
    expected, found = (fired(controller, each, "90 s") for each in (quiet, flooded))
    assert flooded.log_reader.lines
    assert len(expected) == len(found)
    for member in set(expected.dtype.names or ()) - {"time_s"}:  # when it sleeps again, to the us
        assert expected[member].tobytes() == found[member].tobytes(), member


def test_in_eeprom_it_outlives_a_loss_of_power_beside_settings_and_progress() -> None:
    text = changed("kiln", ("1 min, entries: 600}", "5 min, entries: 60, keep: eeprom}"))
    controller = spec_of(text).controller
    device = AvrDevice(controller, whole(text))
    steps = fired(controller, device, "1 h")
    before = told(device, "log")
    assert len(before) == 1 + 12 + 1
    assert not device.avr.eeprom.violations
    device.power_cycle()
    device.sense("chamber", float(steps["temperature_c"][-1]))
    device.advance(device.time_s + 4)
    assert told(device, "log") == before
    assert int(device.read("program.state")) in {1, 3}  # it fires on, or returns to its setpoint
    device.advance(device.time_s + 300)
    assert times_told(device) == [300 * (number + 1) for number in range(13)]


def test_the_page_s_example_reads_it() -> None:
    """pyserial, behind `simulate --serial`."""
    page = (ROOT / "docs" / "serial_log.md").read_text("utf-8")
    found = re.search(r"```python\n(.*?)```", page, re.DOTALL)
    assert found is not None
    with simulated("kiln_uno", SPEED) as (port, baud):
        example = found[1].replace("/dev/ttyUSB0", port).replace("115200", str(baud))
        names: dict[str, Any] = {}
        for _ in range(30):
            time.sleep(1.0)
            exec(example, names)  # noqa: S102 - our own page
            if len(names["rows"]) > 2:
                break
    rows = names["rows"]
    assert rows[0] == PROGRAMMED
    assert all(re.fullmatch(r"\d+,\d+\.\d,\d+\.\d,\d+,\d*,\d*", row) for row in rows[1:])
