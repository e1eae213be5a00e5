"""The generated LinuxCNC files, read without LinuxCNC."""

import re
from configparser import ConfigParser
from xml.etree import ElementTree as ET

import hal_session
import pytest
from hal_session import Hal, linuxcnc_files, of_linuxcnc
from made_up_board import FABRICATOR
from rig.specs import controller_of

from heatwright.generator import plan_firmware, render
from heatwright.sim.interfaces.registers import Register, registers
from heatwright.spec import load_text

LONGEST_IN_HAL = 47
LONGEST = 24
MOST_LOOPS = 8
"""Channels of the ATmega2560's ADC that the simulation knows."""

HEAD = """
heatwright: 1
controller: {{name: {name}, title: '{title}', board: mega2560}}
safety: {{watchdog: 1 s}}
interfaces:
  - {{kind: modbus_rtu, address: 247, baud: {baud}, parity: none, linuxcnc: {linuxcnc}}}
"""
SENSOR = """
  t{n}: {{kind: thermistor, pin: A{n}, divider: {{pull_up: 4.7 kΩ}},
    curve: {{resistance: 10 kΩ, at: 25 °C, beta: 3950 K}}, range: -15 °C .. 110 °C}}
"""
OUTPUT = "  h{n}: {{kind: digital, pin: D{pin}, power: 50 W}}\n"
LOOP = """
  {name}:
    sensor: t{n}
    heater: h{n}
    period: 500 ms
    setpoint: {{initial: 25 °C, minimum: -5 °C, maximum: 80 °C}}
    algorithm: {{kind: on_off, hysteresis: 1 K}}
    protection: {{maximum: 95 °C, minimum: -10 °C, rise_rate: 5 K/s, stale_after: 3 s,
      heating: {{rise: 2 K, within: 2 min}}, runaway: {{above: 8 K, for: 2 min}}}}
"""
TABLES = {
    "fnct_02_read_discrete_inputs": "discrete_input",
    "fnct_04_read_input_registers": "input_register",
    "fnct_05_write_single_coil": "coil",
    "fnct_06_write_single_register": "holding_register",
}
SHORT = {"in-force": "setpoint-in-force"}


def loop_name(number: int) -> str:
    return f"loop_{number}_" + "x" * (LONGEST - len(f"loop_{number}_"))


def many_loops(
    loops: int = MOST_LOOPS, *, name: str = "c" * LONGEST, title: str = "Many", baud: int = 19200,
    linuxcnc: bool = True,
) -> str:  # fmt: skip
    numbers = range(loops)
    text = HEAD.format(name=name, title=title, baud=baud, linuxcnc=str(linuxcnc).lower())
    text += "sensors:\n" + "".join(SENSOR.format(n=n) for n in numbers)
    text += "outputs:\n" + "".join(OUTPUT.format(n=n, pin=22 + n) for n in numbers)
    return text + "loops:\n" + "".join(LOOP.format(n=n, name=loop_name(n)) for n in numbers)


def mb2hal_of(files: dict[str, str]) -> ConfigParser:
    parser = ConfigParser(interpolation=None)
    parser.read_string(next(text for name, text in files.items() if name.endswith(".ini")))
    return parser


def pins_of(register: Register) -> list[str]:
    name = register.name.rpartition(".")[2].replace("_", "-")
    return [name] if register.words == 1 else [f"{name}-high", f"{name}-low"]


def addresses(spec: str) -> dict[tuple[str, int], str]:
    """What stands where, by the simulated master's own map."""
    return {
        (register.table, register.address + offset): pin
        for register in registers(controller_of(spec)).values()
        for offset, pin in enumerate(pins_of(register))
    }


@pytest.mark.parametrize("loops", [1, MOST_LOOPS])
def test_mb2hal_reads_and_writes_what_the_map_has(loops: int) -> None:
    spec = FABRICATOR if loops == 1 else many_loops(loops)
    parser = mb2hal_of(linuxcnc_files(spec))
    places = addresses(spec)
    sections = [parser[name] for name in parser.sections() if name.startswith("TRANSACTION")]
    assert int(parser["MB2HAL_INIT"]["TOTAL_TRANSACTIONS"]) == len(sections) == 3 + 4 * loops
    for section in sections:
        first, table = int(section["FIRST_ELEMENT"]), TABLES[section["MB_TX_CODE"]]
        for offset, pin in enumerate(section["PIN_NAMES"].split(",")):
            assert places[table, first + offset] == SHORT.get(pin, pin), section.name


def test_the_line_is_the_one_of_the_spec() -> None:
    section = mb2hal_of(linuxcnc_files(FABRICATOR))["TRANSACTION_00"]
    names = ("SERIAL_BAUD", "SERIAL_BITS", "SERIAL_PARITY", "SERIAL_STOP", "MB_SLAVE_ID")
    assert [section[name] for name in names] == ["19200", "8", "even", "1", "1"]
    assert section["SERIAL_PORT"] == "fabricator_port"


@pytest.mark.parametrize("baud", [1200, 9600, 19200, 115200])
@pytest.mark.parametrize("loops", [1, MOST_LOOPS])
def test_the_master_is_never_silent_for_half_of_what_counts_as_lost(baud: int, loops: int) -> None:
    text = "\n".join(linuxcnc_files(many_loops(loops, baud=baud)).values())
    busy_s = float(re.search(r"takes about ([\d.]+) s", text)[1])
    rate_hz = float(re.search(r"MAX_UPDATE_RATE = ([\d.]+)", text)[1])
    assert 1 / rate_hz - busy_s < 5 / 2
    heard_s = float(re.search(r"-heard.width ([\d.]+)", text)[1])
    assert heard_s >= 1 + 2 / rate_hz


def test_nothing_is_generated_where_it_is_not_asked_for() -> None:
    assert linuxcnc_files(many_loops(1, linuxcnc=False)) == {}


def test_the_panel_is_xml_whatever_the_texts() -> None:
    title = 'a "b" \\ <c> & --> {{d}} %e% Ω'
    spec = load_text(many_loops(2, title=title), "a--b-->.yaml")
    files = of_linuxcnc(render(plan_firmware(spec)))
    panel = ET.fromstring(next(text for name, text in files.items() if name.endswith(".xml")))  # noqa: S314
    shown = next(each.findtext("text") for each in panel.iter("label"))
    assert eval(shown) == title  # noqa: S307 - as pyvcp does it
    for name, text in files.items():
        banner = text.splitlines()[0]
        assert "Generated by heatwright from a- -b" in banner, name


def test_names_that_are_too_long_are_cut() -> None:
    for text in linuxcnc_files(many_loops()).values():
        for name in re.findall(r"\bc{9,}[-.][\w.-]+", text):
            assert len(name) <= LONGEST_IN_HAL, name


def test_hal_loads_many_loops_with_long_names(linuxcnc: None) -> None:
    files = linuxcnc_files(many_loops())
    with hal_session.folder() as place:
        for name, text in files.items():
            (place / name).write_text(text)
        name = next(name for name in files if name.endswith("_alone.hal"))
        script = "\n".join(
            line for line in files[name].splitlines() if not line.endswith("_panel.hal")
        )
        (place / "test.hal").write_text(script)
        (place / f"{name.removesuffix('_alone.hal')}_port").symlink_to("/dev/null")
        with Hal(place, "test.hal") as hal:
            signals = hal.command("show", "sig")
            for number in range(1, MOST_LOOPS + 1):
                assert f"-loop{number}-setpoint" in signals
            assert hal.signal("ccccccccccccc-loop8-setpoint") == 25
            hal.wait("ccccccccccccc-loop8-setpoint-word", 250)
            hal.set_signal("ccccccccccccc-loop8-setpoint", -4.96)
            hal.wait("ccccccccccccc-loop8-setpoint-word", -50)
