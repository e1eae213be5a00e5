"""build, simulate, verify and compare for real: PlatformIO's binary in the simulated processor."""

import contextlib
import io
import json
import re
from pathlib import Path
from typing import Any

import pytest
from jsonschema import validate
from rig.commands import Heatwright
from rig.specs import EXAMPLES

from heatwright.cli.ends import ended
from heatwright.cli.main import cli
from heatwright.spec import load

NUMBER = {"type": "number"}
WHOLE = {"type": "integer", "minimum": 0}


def exactly(**properties: Any) -> dict[str, Any]:
    return {
        "type": "object",
        "properties": properties,
        "required": list(properties),
        "additionalProperties": False,
    }


BUILD = exactly(flash=WHOLE, ram=WHOLE, stack=WHOLE, flash_limit=WHOLE, ram_limit=WHOLE)
REPLAY = exactly(ticks=WHOLE, mismatches=WHOLE)
CLOSED_LOOP = exactly(
    maximum=NUMBER,
    overshoot=NUMBER,
    tracking={"type": "null"},  # no program ran
    settling_s={"type": ["number", "null"]},
    steady_min=NUMBER,
    steady_max=NUMBER,
    switchings=WHOLE,
    energy_J=NUMBER,
    loads={"type": "array", "maxItems": 0},
)
SECONDS = {"type": ["number", "null"]}
FAULT = exactly(
    fault={"type": "string"},
    rule={"type": ["string", "null"]},
    expected={"type": "array", "items": {"type": "string"}},
    tripped_after_s=SECONDS,
    allowed_s=SECONDS,
    heater_off_after_s=SECONDS,
    peak=NUMBER,
    passed={"type": "boolean"},
    detail={"type": "string"},
)
EVIDENCE = exactly(
    spec={"type": "string"},
    digest={"type": "string", "pattern": "^[0-9a-f]{8}$"},
    core={"const": "own"},
    elf={"type": "null"},
    build=BUILD,
    sensors={"type": "array", "maxItems": 0},  # its thermometer is digital
    replay=REPLAY,
    closed_loop=CLOSED_LOOP,
    faults={"type": "array", "items": FAULT},
    timing={"type": "object"},
    speed=exactly(simulated_s=NUMBER, wall_s=NUMBER),
    passed={"type": "boolean"},
)


Verified = tuple[dict[str, Any], str]


@pytest.fixture(scope="module")
def verified(tmp_path_factory: pytest.TempPathFactory) -> Verified:
    """The chamber, verified once: the JSON, and the page."""
    page = tmp_path_factory.mktemp("verified") / "chamber.html"
    spec, out = str(EXAMPLES / "chamber.yaml"), io.StringIO()
    with contextlib.redirect_stdout(out):
        status = ended(cli, ["verify", spec, "--json", "--report", str(page)])
    assert status in {0, 1}, out.getvalue()
    return json.loads(out.getvalue()), page.read_text(encoding="utf-8")


class TestVerify:
    def test_the_evidence_has_the_promised_form(self, verified: Verified) -> None:
        validate(verified[0], EVIDENCE)

    def test_the_chamber_passes(self, verified: Verified) -> None:
        evidence = verified[0]
        assert [each for each in evidence["faults"] if not each["passed"]] == []
        assert evidence["timing"]["passed"] is True
        assert evidence["passed"] is True
        assert evidence["digest"] == load(EXAMPLES / "chamber.yaml").digest
        assert evidence["replay"]["ticks"] >= 1800
        assert evidence["replay"]["mismatches"] == 0
        assert evidence["build"]["flash"] <= 8826, "what the source's own sketch takes"
        assert evidence["build"]["ram"] <= 345, "what the source's own sketch takes"
        assert evidence["speed"]["simulated_s"] >= 1800

    def test_the_page_tells_the_same_and_needs_nothing_else(self, verified: Verified) -> None:
        evidence, page = verified
        assert ("Passed: all" in page) == evidence["passed"]
        assert f"<b>{evidence['build']['flash']}</b>" in page
        assert evidence["digest"] in page
        assert not re.search(r"(src|href)=", page)
        (text,) = re.findall(r'json">(.*?)</script>', page)
        chart = json.loads(text)
        assert chart["unit"] == "min"
        assert len(chart["panels"]) == 3


def test_build_delivers_what_a_programmer_takes(heatwright: Heatwright) -> None:
    found = heatwright("build chamber.yaml -o firmware --json").json
    validate(found["build"], BUILD)
    assert found["files"] == ["firmware/chamber.elf", "firmware/chamber.hex"]
    assert Path("firmware/chamber.hex").read_text(encoding="ascii").startswith(":")
    assert sorted(path.name for path in Path("firmware").iterdir()) == [
        "chamber.elf", "chamber.hex",
    ]  # fmt: skip


def test_build_for_people(heatwright: Heatwright) -> None:
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
    words = f"simulate {EXAMPLES}/fabricator.yaml --for 8s"
    assert heatwright(f"{words} --json").json["lights"] == {
        "nozzle": {"enabled": "lit", "heating": "lit", "cooling": "dark", "communicating": "lit"}
    }
    told = heatwright(words).out
    assert "LEDs of nozzle: enabled lit, heating lit, cooling dark, communicating lit\n" in told


def test_rows_of_a_comparison_equal_the_model_on_their_binaries(heatwright: Heatwright) -> None:
    (row,) = heatwright("compare oven.yaml --algorithm relay --json").json["rows"]
    assert row["replay"]["mismatches"] == 0
    assert row["replay"]["ticks"] >= 3599
    validate(row["build"], BUILD)
