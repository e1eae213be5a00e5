"""build, simulate, verify and compare for real: PlatformIO's binary in the simulated processor."""

import json
import re
from pathlib import Path
from types import NoneType
from typing import Any

from rig.commands import Heatwright
from rig.specs import EXAMPLES, example

NUMBER = int | float
BUILD = dict.fromkeys(("flash", "ram", "stack", "flash_limit", "ram_limit"), int)
CLOSED_LOOP = {
    "maximum": NUMBER, "overshoot": NUMBER, "tracking": NoneType, "settling_s": NUMBER | None,
    "steady_min": NUMBER, "steady_max": NUMBER, "switchings": int, "energy_J": NUMBER,
    "loads": [None],
}  # fmt: skip
FAULT = {
    "fault": str, "rule": str | None, "expected": [str], "tripped_after_s": NUMBER | None,
    "allowed_s": NUMBER | None, "heater_off_after_s": NUMBER | None, "peak": NUMBER,
    "passed": bool, "detail": str,
}  # fmt: skip
EVIDENCE = {
    "spec": str, "digest": str, "core": str, "elf": NoneType, "build": BUILD, "sensors": [None],
    "replay": {"ticks": int, "mismatches": int}, "closed_loop": CLOSED_LOOP, "faults": [FAULT],
    "timing": dict, "speed": {"simulated_s": NUMBER, "wall_s": NUMBER}, "passed": bool,
}  # fmt: skip
"""The promised keys and types. No program ran, no load was applied, its thermometer is digital."""


def fits(found: Any, form: Any) -> bool:
    """Whether JSON has these keys and types; in a list, None stands for no item at all."""
    if isinstance(form, dict):
        return set(found) == set(form) and all(fits(found[key], form[key]) for key in form)
    if isinstance(form, list):
        return found == [] if form == [None] else all(fits(each, form[0]) for each in found)
    return isinstance(found, form)


class TestVerify:
    def test_the_chamber_passes_and_its_page_tells_the_same(self, heatwright: Heatwright) -> None:
        evidence = heatwright("verify chamber.yaml --json --report chamber.html").json
        assert fits(evidence, EVIDENCE)
        assert [each for each in evidence["faults"] if not each["passed"]] == []
        assert evidence["timing"]["passed"] is True
        assert evidence["passed"] is True
        assert evidence["digest"] == example("chamber").digest
        assert evidence["replay"]["ticks"] >= 1800
        assert evidence["replay"]["mismatches"] == 0
        assert evidence["build"]["flash"] <= 8826, "what the source's own sketch takes"
        assert evidence["build"]["ram"] <= 345, "what the source's own sketch takes"
        assert evidence["speed"]["simulated_s"] >= 1800
        page = Path("chamber.html").read_text(encoding="utf-8")
        assert "Passed: all" in page
        assert f"<b>{evidence['build']['flash']}</b>" in page
        assert evidence["digest"] in page
        assert not re.search(r"(src|href)=", page), "it needs nothing else"
        (text,) = re.findall(r'json">(.*?)</script>', page)
        chart = json.loads(text)
        assert (chart["unit"], len(chart["panels"])) == ("min", 3)


def test_build_delivers_what_a_programmer_takes(heatwright: Heatwright) -> None:
    found = heatwright("build chamber.yaml -o firmware --json").json
    assert fits(found["build"], BUILD)
    assert found["files"] == ["firmware/chamber.elf", "firmware/chamber.hex"]
    assert sorted(map(str, Path("firmware").iterdir())) == found["files"]
    assert Path("firmware/chamber.hex").read_text(encoding="ascii").startswith(":")
    told = heatwright("build chamber.yaml").out
    assert re.match(r"flash +\d+ of 32256 bytes\nRAM +\d+ of 2048 bytes, static\n", told)
    assert Path(told.splitlines()[-1]).is_file()


def test_the_binary_shows_and_sends_what_it_does(heatwright: Heatwright) -> None:
    found = heatwright("simulate chamber.yaml --for 1min --vcd pins.vcd --json").json
    assert found["device"] == "binary"
    assert found["display"][1] == "Set temp 50°C   "
    text = Path("pins.vcd").read_text(encoding="ascii")
    assert " D3_heater $end" in text
    assert " D9_display_E $end" in text
    assert text.count("\n#") > 1000


def test_what_leds_show_is_told(heatwright: Heatwright) -> None:
    words = f"simulate {EXAMPLES}/fabricator.yaml --for 4s"
    assert heatwright(f"{words} --json").json["lights"] == {
        "nozzle": {"enabled": "lit", "heating": "lit", "cooling": "dark", "communicating": "lit"}
    }
    told = heatwright(words).out
    assert "LEDs of nozzle: enabled lit, heating lit, cooling dark, communicating lit\n" in told


class TestCompare:
    def test_rows_equal_the_model_on_their_binaries(self, heatwright: Heatwright) -> None:
        (row,) = heatwright("compare oven.yaml --algorithm relay --json").json["rows"]
        assert row["replay"]["mismatches"] == 0
        assert row["replay"]["ticks"] >= 3599
        assert fits(row["build"], BUILD)
