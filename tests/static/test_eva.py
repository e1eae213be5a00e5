"""What Eva proves of the examples' firmware; `eva` tells how, and under what model of the world.

Only those are here of which it proves all. It takes minutes of a processor each.
"""

import re
import shutil
from pathlib import Path

import pytest
from eva import Proof, proof_of
from rig.firmware import controller_of, sources_of

ON = "    UCSR0B |= (1u << UDRIE0);\n"
PROVEN = ("barrel", "chamber", "dryer", "fabricator", "hotplate", "incubator", "oven", "press")
DAMAGED = ("chamber", "press", "barrel", "fabricator")
BEYOND = re.compile(r"out of bounds|in_eeprom")


def proof(name: str, sources: dict[str, str], folder: Path, *, damaged: bool = False) -> Proof:
    assert shutil.which("frama-c"), "make setup EVIDENCE=1"
    return proof_of(name, sources, folder, damaged=damaged)


@pytest.mark.parametrize("name", PROVEN)
def test_no_run_does_what_c_leaves_undefined(name: str, tmp_path: Path) -> None:
    """And a heater is off without a permit or with a fault, and a duty is from 0 to 100 %."""
    found = proof(name, sources_of(name), tmp_path)
    assert found.alarms == ()
    assert found.asserted == 1 + 2 * len(controller_of(name).loops)
    assert found.unreached == ()


@pytest.mark.parametrize("name", DAMAGED)
def test_whatever_the_ram_holds_no_index_leaves_its_array(name: str, tmp_path: Path) -> None:
    """A display's cell did, a slot of the EEPROM, a byte on a 1-Wire line."""
    alarms = proof(name, sources_of(name), tmp_path, damaged=True).alarms
    assert [alarm for alarm in alarms if BEYOND.search(alarm)] == []


def test_what_is_broken_is_told(tmp_path: Path) -> None:
    """Also what only interrupts do, or only an interrupt at one place."""
    sources = sources_of("press")
    for file, old, new in (
        ("serial.c", "next < size && next < sizeof to_send", "next <= sizeof to_send"),
        ("serial.c", ON, f"{ON}    size = (uint8_t)(size / (uint8_t)(sent == 0));\n"),
        ("gate.c", "platen_permitted = healthy;", "platen_permitted = left != 0;"),
        ("loop_platen.c", "duty_percent = algorithm_", "duty_percent = 1.01f * algorithm_"),
    ):
        assert sources[file].count(old) == 1, old
        sources[file] = sources[file].replace(old, new)
    told = proof("press", sources, tmp_path).alarms
    for kind in ("out of bounds index", "division by zero", "'off_heater'", "'duty'"):
        assert any(kind in alarm for alarm in told), (kind, told)
