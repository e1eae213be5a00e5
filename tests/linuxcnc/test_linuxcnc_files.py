"""The generated LinuxCNC files, read without LinuxCNC, and what docs/linuxcnc.md says of them."""

import re
from configparser import ConfigParser
from xml.etree import ElementTree as ET

import hal_session
import pytest
from hal_session import FABRICATOR, Hal, linuxcnc_files
from rig.firmware import ROOT, controller_of, files_of

from heatwright.generator import plan_firmware, render
from heatwright.sim.interfaces.modbus_rtu.registers import registers
from heatwright.spec import load_text

DOCS = (ROOT / "docs" / "linuxcnc.md").read_text("utf-8")
LONGEST = 24
MOST_LOOPS = 8  # channels of the ATmega2560's ADC that the simulation knows

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
    {{sensor: t{n}, heater: h{n}, period: 500 ms, algorithm: {{kind: on_off, hysteresis: 1 K}},
     setpoint: {{initial: 25 °C, minimum: -5 °C, maximum: 80 °C}},
     protection: {{maximum: 95 °C, minimum: -10 °C, rise_rate: 5 K/s, stale_after: 3 s,
       heating: {{rise: 2 K, within: 2 min}}, runaway: {{above: 8 K, for: 2 min}}}}}}
"""
TABLES = {
    "fnct_02_read_discrete_inputs": "discrete_input",
    "fnct_04_read_input_registers": "input_register",
    "fnct_05_write_single_coil": "coil",
    "fnct_06_write_single_register": "holding_register",
}
SHORT = {"in-force": "setpoint-in-force"}


@pytest.fixture(scope="module")
def generated() -> dict[str, str]:
    return linuxcnc_files(files_of(FABRICATOR))


def loop_name(number: int) -> str:
    return f"loop_{number}_" + "x" * (LONGEST - len(f"loop_{number}_"))


def many_loops(
    loops: int = MOST_LOOPS, *, title: str = "Many", baud: int = 19200, linuxcnc: str = "true"
) -> str:
    head = HEAD.format(name="c" * LONGEST, title=title, baud=baud, linuxcnc=linuxcnc)
    sensors, outputs, each = (
        "".join(part.format(n=n, pin=22 + n, name=loop_name(n)) for n in range(loops))
        for part in (SENSOR, OUTPUT, LOOP)
    )
    return f"{head}sensors:{sensors}outputs:\n{outputs}loops:{each}"


def mb2hal_of(files: dict[str, str]) -> ConfigParser:
    parser = ConfigParser(interpolation=None)
    parser.read_string(next(text for name, text in files.items() if name.endswith(".ini")))
    return parser


def addresses(spec: str) -> dict[tuple[str, int], str]:
    found = {}
    for register in registers(controller_of(spec)).values():
        name = register.name.rpartition(".")[2].replace("_", "-")
        for offset, word in enumerate(("-high", "-low") if register.words == 2 else ("",)):
            found[register.table, register.address + offset] = name + word
    return found


@pytest.mark.parametrize("loops", [1, MOST_LOOPS])
def test_mb2hal_reads_and_writes_what_the_map_has(loops: int) -> None:
    spec = FABRICATOR if loops == 1 else many_loops(loops)
    parser = mb2hal_of(linuxcnc_files(files_of(spec)))
    places = addresses(spec)
    sections = [parser[name] for name in parser.sections() if name.startswith("TRANSACTION")]
    assert int(parser["MB2HAL_INIT"]["TOTAL_TRANSACTIONS"]) == len(sections) == 3 + 4 * loops
    for section in sections:
        first, table = int(section["FIRST_ELEMENT"]), TABLES[section["MB_TX_CODE"]]
        for offset, pin in enumerate(section["PIN_NAMES"].split(",")):
            assert places[table, first + offset] == SHORT.get(pin, pin), section.name


def test_the_line_is_the_one_of_the_spec() -> None:
    section = mb2hal_of(linuxcnc_files(files_of(FABRICATOR)))["TRANSACTION_00"]
    names = ("SERIAL_BAUD", "SERIAL_BITS", "SERIAL_PARITY", "SERIAL_STOP", "MB_SLAVE_ID")
    assert [section[name] for name in names] == ["19200", "8", "even", "1", "1"]
    assert section["SERIAL_PORT"] == "fabricator_port"
    assert linuxcnc_files(files_of(many_loops(1, linuxcnc="false"))) == {}, "nobody asks for it"


@pytest.mark.parametrize("baud", [1200, 9600, 19200, 115200])
@pytest.mark.parametrize("loops", [1, MOST_LOOPS])
def test_the_master_is_never_silent_for_half_of_what_counts_as_lost(baud: int, loops: int) -> None:
    text = "\n".join(linuxcnc_files(files_of(many_loops(loops, baud=baud))).values())
    busy_s = float(re.search(r"takes about ([\d.]+) s", text)[1])
    rate_hz = float(re.search(r"MAX_UPDATE_RATE = ([\d.]+)", text)[1])
    assert 1 / rate_hz - busy_s < 5 / 2
    heard_s = float(re.search(r"-heard.width ([\d.]+)", text)[1])
    assert heard_s >= 1 + 2 / rate_hz


def test_the_panel_is_xml_whatever_the_texts() -> None:
    title = 'a "b" \\ <c> & --> {{d}} %e% Ω'
    spec = load_text(many_loops(2, title=title), "a--b-->.yaml")
    files = linuxcnc_files(render(plan_firmware(spec)))
    panel = ET.fromstring(next(text for name, text in files.items() if name.endswith(".xml")))  # noqa: S314
    shown = next(each.findtext("text") for each in panel.iter("label"))
    assert eval(shown) == title  # noqa: S307 - as pyvcp does it
    for name, text in files.items():
        banner = text.splitlines()[0]
        assert "Generated by heatwright from a- -b" in banner, name


def test_hal_loads_many_loops_with_long_names() -> None:
    files = linuxcnc_files(files_of(many_loops()))
    with hal_session.folder() as place:
        for name, text in files.items():
            (place / name).write_text(text)
        name = next(name for name in files if name.endswith("_alone.hal"))
        lines = files[name].splitlines()
        script = "\n".join(line for line in lines if not line.endswith("_panel.hal"))
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


def test_what_the_page_names_is_generated(generated: dict[str, str]) -> None:
    """Signals, files, pins of mb2hal, and numbers."""
    signals = set(re.findall(r"^net +(\S+)", generated["fabricator.hal"], re.MULTILINE))
    named = set(re.findall(r"\bfabricator-[a-z-]*[a-z]", DOCS)) - {"fabricator-panel"}
    assert named <= signals
    files = set(re.findall(r"\bfabricator(?:_\w+)?\.(?:hal|xml|ini)", DOCS))
    assert files == set(generated)
    ini = generated["fabricator_mb2hal.ini"]
    for request, pin in re.findall(r"`fabricator\.([\w-]+)\.([\w-]+)(?:\.int)?`", DOCS):
        assert f"HAL_TX_NAME = {request}\n" in ini
        assert pin == "num_errors" or re.search(rf"PIN_NAMES = .*\b{pin}\b", ini), pin
    busy_s, rate_hz = re.search(r"takes ([\d.]+) s at 19200 baud.* ([\d.]+) times a", DOCS).groups()
    assert f"takes about {busy_s}" in ini
    assert f"MAX_UPDATE_RATE = {rate_hz}\n" in ini
    heard = re.search(r"-heard.width (\S+)", generated["fabricator.hal"])[1]
    assert f"with {heard} s the speed can be about 5" in DOCS


def test_every_signal_has_one_writer_and_nobody_waits_for_one_that_is_not_there(
    generated: dict[str, str],
) -> None:
    text = generated["fabricator.hal"] + generated["fabricator_panel.hal"]
    written, read = set(), set()
    for line in re.findall(r"^net .*", text, re.MULTILINE):
        name = line.split()[1]
        if "<=" in line:
            assert name not in written, name
            written.add(name)
        if "=>" in line:
            read.add(name)
    assert read - written == {"fabricator-inhibit"}
    assert written - read <= set(re.findall(r"fabricator-[a-z-]*[a-z]", DOCS))


def test_every_component_runs_once_in_each_round_of_the_thread(generated: dict[str, str]) -> None:
    text = generated["fabricator.hal"]
    loaded = ",".join(re.findall(r"^loadrt \w+ names=(\S+)", text, re.MULTILINE)).split(",")
    added = re.findall(r"^addf (\S+) servo-thread$", text, re.MULTILINE)
    assert len(loaded) > 10
    assert sorted(loaded) == sorted(added)
