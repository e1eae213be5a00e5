"""What Eva proves of the examples' firmware; `eva` tells how, and under what model of the world. It
takes minutes of a processor each."""

import re
import shutil
from pathlib import Path

import pytest
from eva import ASKS, GIVES, SPLITS, Proof, proof_of
from points import Firmware, pointed
from rig.firmware import EXAMPLE_NAMES, controller_of, sources_of

ON = "    UCSR0B |= (1u << UDRIE0);\n"
UNREACHED = {"kiln_uno": ("follow",)}  # nobody commands its manual mode
DAMAGED = ("chamber", "press", "barrel", "fabricator")
ROUTINES = """static uint8_t head;
static uint8_t tail;
static uint8_t bytes[4];
static uint16_t ticks;
static uint16_t other;
uint8_t seen;
uint8_t kept;
ISR(USART_RX_vect) { bytes[head] = UDR0; head++; seen = kept; }
static void spend(uint16_t *left) { *left = 0; }
ISR(TIMER1_COMPA_vect) { spend(&ticks); }
void fill(uint8_t *to) {
%s
}
"""
RX, TIMER = "POINT(0) ", "POINT(1) "
STATEMENTS = {
    "tail = kept;": "",  # only read by an interrupt
    "kept = tail;": RX,
    "tail = head;": RX,
    "spend(&other);": "",
    "spend(&ticks);": TIMER,
    "*to = 1;": RX + TIMER,  # bytes may be of anything that a pointer leads to
    "bytes[0] = 1;": RX,
    "fill(bytes);": RX,
    "{ uint8_t head; head = 1; }": "",
    "cli();": RX + TIMER,
    "memset(to, 0, 4);": RX + TIMER,
    "if (tail == 0) { tail = 1; } else if (head == 0) { tail = 2; }": RX,
    "kept += tail && ticks > 2;": RX + TIMER,
}
BEYOND = re.compile(r"out of bounds|in_eeprom")


def proof(name: str, sources: dict[str, str], folder: Path, *, damaged: bool = False) -> Proof:
    assert shutil.which("frama-c"), "make setup EVIDENCE=1"
    return proof_of(name, sources, folder, damaged=damaged)


@pytest.mark.parametrize("name", EXAMPLE_NAMES)
def test_no_run_does_what_c_leaves_undefined(name: str, tmp_path: Path) -> None:
    """And a heater is off without a permit or with a fault, and a duty is from 0 to 100 %."""
    found = proof(name, sources_of(name), tmp_path)
    assert (found.alarms, found.asserted) == ((), 1 + 3 * len(controller_of(name).loops))
    assert found.unreached == UNREACHED.get(name, ())


@pytest.mark.parametrize("name", DAMAGED)
def test_whatever_the_ram_holds_no_index_leaves_its_array(name: str, tmp_path: Path) -> None:
    """A display's cell did, a slot of the EEPROM, a byte on a 1-Wire line."""
    alarms = proof(name, sources_of(name), tmp_path, damaged=True).alarms
    assert [alarm for alarm in alarms if BEYOND.search(alarm)] == []


@pytest.mark.parametrize("statement", STATEMENTS)
def test_interrupts_come_where_it_makes_a_difference(statement: str) -> None:
    text = ROUTINES % f"fill(bytes);\n{statement}"
    line = pointed("a.c", text, Firmware({"a.c": text}), 9).splitlines()[12]
    points = STATEMENTS[statement]
    assert points in line
    assert line.count("POINT") == points.count("POINT"), line
    assert ("else if" not in line and "&&" not in line) or "(interrupts_on ? interrupts_" in line


def test_each_function_that_is_told_apart_is_there() -> None:
    texts = [text for name in EXAMPLE_NAMES for text in sources_of(name).values()]
    for name in {*ASKS, *GIVES, *SPLITS}:
        assert any(re.search(rf"^[\w ]+ \*?{name}\(.*\)\n{{", text, re.M) for text in texts), name


def test_what_is_broken_is_told(tmp_path: Path) -> None:
    """Also what only interrupts do, or only an interrupt at one place."""
    sources = sources_of("press")
    for file, old, new in (
        ("serial.c", "next < size && next < sizeof to_send", "next <= sizeof to_send"),
        ("serial.c", ON, f"{ON}    size = (uint8_t)(size / (uint8_t)(sent == 0));\n"),
        ("gate.c", "platen_permitted = healthy;", "platen_permitted = left != 0;"),
        ("output_heater.c", "if (permitted && ", "if ("),
        ("loop_platen.c", "duty_percent = algorithm_", "duty_percent = 1.01f * algorithm_"),
    ):
        assert sources[file].count(old) == 1, old
        sources[file] = sources[file].replace(old, new)
    told = proof("press", sources, tmp_path).alarms
    kinds = "out of bounds index", "division by zero", "'permits_heater'", "'off_heater'", "'duty'"
    for kind in kinds:
        assert any(kind in alarm for alarm in told), (kind, told)
