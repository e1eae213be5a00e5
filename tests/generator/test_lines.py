"""The README of a project names what stands between a serial port's pins and its line."""

import re
from typing import Any

import pytest
from rig.specs import changed, files_of

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


def test_a_leonardos_socket_is_no_line() -> None:
    """Its serial port is on pins alone, and no bootloader speaks there."""
    assert f"| USB | {ADAPTER.format('D0 = PD2', 'D1 = PD3')} |" in readme(LEONARDO)


def test_a_board_without_a_line_has_no_such_page() -> None:
    plotter = "interfaces:\n  - {kind: serial_plotter, loop: air, baud: 9600}\n"
    without = changed("incubator", (plotter, ""))
    assert "Levels of the lines" in readme("incubator")
    assert "Levels of the lines" not in readme(without)


def readme(spec: str) -> str:
    return files_of(spec)["README.md"]
