"""docs/linuxcnc.md names what is generated, by its name."""

import re
from pathlib import Path

DOCS = (Path(__file__).parents[2] / "docs" / "linuxcnc.md").read_text("utf-8")
SIGNAL = re.compile(r"^net +(\S+)", re.MULTILINE)


def test_its_signals_and_files_are_generated(generated: dict[str, str]) -> None:
    signals = set(SIGNAL.findall(generated["fabricator.hal"]))
    named = set(re.findall(r"\bfabricator-[a-z-]*[a-z]", DOCS)) - {"fabricator-panel"}
    assert named <= signals
    files = set(re.findall(r"\bfabricator(?:_\w+)?\.(?:hal|xml|ini)", DOCS))
    assert files == set(generated)


def test_its_pins_are_mb2hals(generated: dict[str, str]) -> None:
    ini = generated["fabricator_mb2hal.ini"]
    for request, pin in re.findall(r"`fabricator\.([\w-]+)\.([\w-]+)(?:\.int)?`", DOCS):
        assert f"HAL_TX_NAME = {request}\n" in ini
        assert pin == "num_errors" or re.search(rf"PIN_NAMES = .*\b{pin}\b", ini), pin


def test_its_numbers_are_the_generated_ones(generated: dict[str, str]) -> None:
    ini = generated["fabricator_mb2hal.ini"]
    busy_s, rate_hz = re.search(r"takes ([\d.]+) s at 19200 baud.* ([\d.]+) times a", DOCS).groups()
    assert f"takes about {busy_s}" in ini
    assert f"MAX_UPDATE_RATE = {rate_hz}\n" in ini
    heard = re.search(r"-heard.width (\S+)", generated["fabricator.hal"])[1]
    assert f"{heard} s of it allow a speed of about 5" in DOCS


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
    loaded = [
        name
        for names in re.findall(r"^loadrt \w+ names=(\S+)", text, re.MULTILINE)
        for name in names.split(",")
    ]
    added = re.findall(r"^addf (\S+) servo-thread$", text, re.MULTILINE)
    assert len(loaded) > 10
    assert sorted(loaded) == sorted(added)
