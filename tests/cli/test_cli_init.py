"""`init`: what it offers goes together, passes `check`, and is verified."""

import os
import pty
import sys
from pathlib import Path

import pytest
from rig.commands import Heatwright
from rig.verified import rehearsed, verified
from suite import amount

from heatwright.cli.ends import ended
from heatwright.cli.main import cli
from heatwright.cli.starters.composed import Choice, choices, composed, machines, names, parts
from heatwright.spec import BOARDS, Spec, load_text

CHOICES = choices()
USUAL = {each.machine: each for each in reversed(CHOICES)}
SERVED = {each.interface: each for each in reversed(CHOICES)}
MACHINES = {each._replace(board=""): each for each in CHOICES}
"""One of each machine, sensor, output and interface; the board changes nothing that runs."""


def spec_of(choice: Choice) -> Spec:
    return load_text(composed(choice, "mine", "mine.yaml"), "mine.yaml")


def test_every_name_can_be_chosen() -> None:
    assert set(parts()["boards"]) == set(BOARDS)
    for kind in Choice._fields:
        offered = machines() if kind == "machine" else parts()[f"{kind}s"]
        assert set(names(CHOICES, kind)) == set(offered)


@pytest.mark.parametrize("choice", CHOICES, ids="-".join)
def test_what_it_offers_is_good(choice: Choice) -> None:
    controller = spec_of(choice).controller
    assert controller.identity.board == choice.board
    assert {each.kind for each in controller.sensors.values()} == {choice.sensor}
    heaters = [controller.outputs[each.heater] for each in controller.loops.values()]
    assert {each.kind for each in heaters} == {choice.output}
    assert [each.kind for each in controller.interfaces] == [choice.interface]


@pytest.mark.parametrize("choice", MACHINES.values(), ids="-".join)
def test_nothing_trips_on_its_machine(choice: Choice) -> None:
    assert rehearsed(spec_of(choice)) == ()


@pytest.mark.parametrize("choice", dict.fromkeys((*USUAL.values(), *SERVED.values())), ids="-".join)
def test_the_usual_one_of_each_machine_and_interface_verifies(choice: Choice) -> None:
    found = verified(spec_of(choice), amount("machine_faults"))
    assert found.fits
    assert found.red == ()


def test_what_is_written_is_the_choice_and_its_schema(heatwright: Heatwright) -> None:
    told = heatwright("init 'My bath.yaml' --machine sous_vide --sensor rtd --json").json
    written = ["My bath.yaml", "heatwright.schema.json"]
    assert told == {"file": "My bath.yaml", "written": written}
    first, *others = Path("My bath.yaml").read_text(encoding="utf-8").splitlines()
    assert first == f"# yaml-language-server: $schema={written[1]}"
    assert any(line.startswith("  name: my_bath  ") for line in others)
    assert heatwright("schema").out == Path(written[1]).read_text(encoding="utf-8")
    assert heatwright("init next.yaml --json").json["written"] == ["next.yaml"]


def test_its_help_names_what_there_is(heatwright: Heatwright) -> None:
    told = " ".join(heatwright("init --help").out.split())
    for kind in Choice._fields:
        assert f"{', '.join(names(CHOICES, kind))}." in told


def test_an_example_is_written_whole(heatwright: Heatwright) -> None:
    heatwright("init mine.yaml --example fabricator")
    heatwright("generate mine.yaml")
    assert Path("generated/mine/linuxcnc").is_dir()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--machine oven", "--machine: there is no such machine as oven. Use chamber, sous_vide, "),
        ("--machine kiln --sensor ds18b20", "no such machine with ds18b20. Use max31856, "),
        ("--board nano --interface lcd_keypad", "machine with lcd_keypad. Use modbus_rtu, "),
        ("--example toaster", "--example: there is no toaster. Use barrel, chamber, "),
        ("--example kiln --board uno", "leave out --board or --example."),
    ],
)
def test_what_does_not_go_is_told(heatwright: Heatwright, words: str, said: str) -> None:
    assert said in heatwright(f"init new.yaml {words}", status=2).err
    assert not Path("new.yaml").exists()


def test_a_terminal_is_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    ours, theirs = pty.openpty()
    os.write(ours, b"kiln\noven\nmega2560\n\nnextion\n")
    with os.fdopen(theirs) as terminal:
        monkeypatch.setattr(sys, "stdin", terminal)
        assert ended(cli, ["init", "new.yaml", "--output", "time_proportional"]) == 0
    os.close(ours)
    asked = capfd.readouterr().err
    assert "'oven' is not one of " in asked
    assert "Output:" not in asked
    chosen = Choice("kiln", "mega2560", "max31856", "time_proportional", "nextion")
    assert Path("new.yaml").read_text("utf-8") == composed(chosen, "new", "new.yaml")
