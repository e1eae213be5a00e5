"""The operator chooses the thermocouple's type on the touch display: the kiln's binary."""

from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import pytest

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.toolchain import build
from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.sim.sensors.max31856 import Max31856
from heatwright.spec import Spec, load

KILN = Path(__file__).parents[2] / "spec" / "examples" / "kiln.yaml"
J, K, S = 2, 3, 6
"""Codes of types; the kiln's operator may choose K and S."""
ROOM_C = 25.0
SAVED_S = 15.0
"""Until a choice is in the EEPROM: it waits 10 s for another one."""


SENSOR = "src/sensor_chamber.c"
MUTANTS = [
    ("if (loop_chamber.enabled || loop_chamber_is_enabled())", "if (loop_chamber.enabled)"),
    ("if (loop_chamber.enabled || loop_chamber_is_enabled())", "if (loop_chamber_is_enabled())"),
    ("if (program.state != PROGRAM_IDLE)", "if (program.state == PROGRAM_RUNNING)"),
    ("if (type != settings.chamber_thermocouple)", "if (ticks_left == 0xFFFFu)"),
    ("        type = settings.chamber_thermocouple;\n", ""),
    ("        spi_chamber_end();\n        enter(CHOOSING);\n    }", "    }"),
]


@cache
def kiln() -> Spec:
    return load(KILN)


@cache
def program(old: str = "", new: str = "") -> Elf:
    """Its binary; with something else in the place of some text of the sensor's C."""
    files = dict(render(plan_firmware(kiln())))
    assert not old or files[SENSOR].count(old) == 1, old
    files[SENSOR] = files[SENSOR].replace(old, new) if old else files[SENSOR]
    folder = Path(mkdtemp(prefix="kiln-"))
    write(files, folder)
    return Elf(build(folder).elf)


def cold(program: Elf) -> AvrDevice:
    """A cold kiln, where every type reads the same."""
    device = AvrDevice(kiln().controller, program)
    device.sense("chamber", ROOM_C)
    device.advance(3.02)
    return device


@pytest.fixture
def device() -> AvrDevice:
    return cold(program())


def chip(device: AvrDevice) -> Max31856:
    found = device.sensors["chamber"]
    assert isinstance(found, Max31856)
    return found


def choose(device: AvrDevice, code: int) -> None:
    device.send(f"#15 {code};")
    device.advance(device.time_s + 2.0)


def chosen(device: AvrDevice) -> tuple[int, int]:
    """What the settings say, and the chip."""
    return int(device.read("settings.chamber_thermocouple")), chip(device)._registers[1] & 0xF


def test_it_is_taken_over_with_the_next_reading(device: AvrDevice) -> None:
    assert chosen(device) == (K, K)
    done = len(device.steps("chamber"))
    choose(device, S)
    assert chosen(device) == (S, S)
    device.advance(device.time_s + 1.0)
    after = device.steps("chamber")[done:]
    assert after["reading_status"].tolist() == [0] * len(after)
    assert set(after["reading_raw"].tolist()) == {round(128 * ROOM_C)}
    assert device.read("fault.code") == 0
    chip(device).wire = "S"
    device.sense("chamber", ROOM_C + 4)
    device.advance(device.time_s + 2.0)
    assert device.steps("chamber")["reading_raw"][-1] == round(128 * (ROOM_C + 4))


def test_a_warm_kiln_jumps(device: AvrDevice) -> None:
    """4.096 mV above a junction at 25 °C is 124 °C for type K: for type S it is some 500 °C."""
    for warmer_c in range(30, 126, 5):
        device.sense("chamber", warmer_c)
        device.advance(device.time_s + 1.0)
    assert device.read("fault.code") == 0
    choose(device, S)
    device.advance(device.time_s + 1.0)
    assert device.steps("chamber")["temperature_c"].max() > 150.0
    assert device.read("fault.code") == 8


@pytest.mark.parametrize("code", [J, 8, 255, 256 + S])
def test_only_what_may_be_chosen(device: AvrDevice, code: int) -> None:
    choose(device, code)
    assert chosen(device) == (K, K)


def test_not_while_a_program_runs_or_waits(device: AvrDevice) -> None:
    device.program("start", 1)
    device.advance(device.time_s + 2.0)
    choose(device, S)
    assert chosen(device) == (K, K)
    device.program("pause")
    device.advance(device.time_s + 2.0)
    choose(device, S)
    assert chosen(device) == (K, K)
    device.program("stop")
    device.advance(device.time_s + 2.0)
    choose(device, S)
    assert chosen(device) == (S, S)


def test_not_while_the_loop_is_on(device: AvrDevice) -> None:
    device.send("#2 1;")
    device.advance(device.time_s + 2.0)
    assert device.read("loop_chamber.enabled") == 1
    choose(device, S)
    assert chosen(device) == (K, K)
    device.send("#2 0;")
    device.advance(device.time_s + 2.0)
    choose(device, S)
    assert chosen(device) == (S, S)


def test_not_when_it_is_switched_before_the_next_step_sees_it(device: AvrDevice) -> None:
    for order in ("#2 1;#15 6;", "#2 0;#15 6;"):
        device.send(order)
        device.advance(device.time_s + 2.0)
        assert chosen(device) == (K, K)


def test_it_outlives_a_loss_of_power(device: AvrDevice) -> None:
    choose(device, S)
    device.advance(device.time_s + SAVED_S)
    device.power_cycle()
    device.sense("chamber", ROOM_C)
    device.advance(device.time_s + 3.02)
    assert chosen(device) == (S, S)
    assert set(device.steps("chamber")["reading_status"].tolist()) == {0}


def found(broken: Elf) -> bool:
    """Whether one of the tests above sees what is broken."""
    for check in (
        test_it_is_taken_over_with_the_next_reading,
        test_not_while_a_program_runs_or_waits,
        test_not_when_it_is_switched_before_the_next_step_sees_it,
    ):
        try:
            check(cold(broken))
        except AssertionError:
            return True
    return False


@pytest.mark.parametrize("number", range(len(MUTANTS)))
def test_a_broken_one_is_seen(number: int) -> None:
    assert found(program(*MUTANTS[number])), MUTANTS[number]
