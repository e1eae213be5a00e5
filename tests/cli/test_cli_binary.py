"""PlatformIO's binary in the simulated processor, by command; and what verify judges."""

import json
import re
import shlex
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from types import NoneType, SimpleNamespace
from typing import Any

import pytest
from rig.commands import Heatwright, printer_rows
from rig.firmware import EXAMPLES, ROOT, example

from heatwright.cli.beside import with_scenario
from heatwright.cli.running import run_model
from heatwright.cli.talk import _PlainJob
from heatwright.cli.verify.checks import replay_checks, run_checks
from heatwright.cli.verify.trials import ClosedLoop, closed_loop, long_enough
from heatwright.generator.toolchain import BuildResult
from heatwright.sim.comparison import row_scenario
from heatwright.sim.faults import FaultResult
from heatwright.sim.plots.plot import run_figure
from heatwright.sim.replay import replay
from heatwright.sim.timing import Cost, Figure, Timing
from heatwright.spec import Controller, Event, Expect, Simulation

NUMBER = int | float
BUILD = dict.fromkeys(("flash", "ram", "stack", "flash_limit", "ram_limit"), int)
CLOSED_LOOP = {
    "maximum": NUMBER, "overshoot": NUMBER, "tracking": NoneType, "settling_s": NUMBER | None,
    "steady_min": NUMBER, "steady_max": NUMBER, "switchings": int, "energy_J": NUMBER,
    "loads": [None],
}  # fmt: skip
FAULT = {
    "fault": str, "loop": str, "calm": bool, "rule": str | None, "counting": [str],
    "tripped_after_s": NUMBER | None, "allowed_s": NUMBER | None,
    "heater_off_after_s": NUMBER | None,
    "peak": NUMBER, "passed": bool, "detail": str,
}  # fmt: skip
UPSET = {
    "number": int, "loop": str, "state": str, "after_s": NUMBER, "kind": str, "address": int,
    "bit": int, "result": str, "words": str,
}  # fmt: skip
REPLAY = {"ticks": int, "mismatches": int}
ROWS = [
    (path.stem, algorithm)
    for path in sorted(EXAMPLES.glob("*.yaml"))
    for algorithm in dict.fromkeys(row.name for row in example(path.stem).controller.comparison)
]
EVIDENCE = {
    "spec": str, "digest": str, "core": str, "elf": NoneType, "build": BUILD, "sensors": [None],
    "replay": REPLAY, "loops": {"air": {"closed_loop": CLOSED_LOOP, "replay": REPLAY}},
    "faults": [FAULT], "faults_left_out": int, "upsets": [UPSET],
    "timing": dict, "passed": bool,
    "speed": dict.fromkeys(("simulated_s", "wall_s", "awake_cycles_per_s", "cycle_ns"), NUMBER),
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
        words = "verify chamber.yaml --json --report chamber.html --upsets 3 --first 40"
        evidence = heatwright(words).json
        assert fits(evidence, EVIDENCE)
        assert [each["number"] for each in evidence["upsets"]] == [40, 41, 42]
        assert [each for each in evidence["faults"] if not each["passed"]] == []
        assert evidence["timing"]["passed"] is evidence["passed"] is True
        assert evidence["digest"] == example("chamber").digest
        assert evidence["replay"]["ticks"] >= 1800
        assert evidence["replay"]["mismatches"] == 0
        readme = (ROOT / "README.md").read_text(encoding="utf-8")
        (told,) = re.findall(r"PASSED: all (\d+) checks hold", readme)
        drawn = {each["kind"] for each in evidence["upsets"]}  # each of them is a check, too
        page = Path("chamber.html").read_text(encoding="utf-8")
        for words in (
            f"all {int(told) + len(drawn)} checks hold", "Passed: all", "with keys pressed",
            "upsets: ", f"<b>{evidence['build']['flash']}</b>", evidence["digest"],
        ):  # fmt: skip
            assert words in page
        assert not re.search(r"(src|href)=", page), "it needs nothing else"
        (text,) = re.findall(r'json">(.*?)</script>', page)
        chart = json.loads(text)
        assert (chart["unit"], len(chart["panels"])) == ("min", 3)

    def test_one_fault_alone_is_tried_again(self, heatwright: Heatwright) -> None:
        names = ["power_cut", "jump_up"]
        asked = " ".join(f"--fault {each}" for each in names)
        found = heatwright(f"verify chamber.yaml {asked} --json").json
        assert sorted(each["fault"] for each in found["faults"]) == sorted(names)
        assert found["faults_left_out"] > 40
        assert found["passed"] is True
        told = heatwright("verify chamber.yaml --fault power_cut").out
        assert re.search(r"PASSED: all \d+ checks hold\. Not tried: \d+ faults\.$", told.strip())
        refused = heatwright("verify chamber.yaml --fault power_cat", status=2).err
        assert "no fault 'power_cat'. Did you mean power_cut?" in refused


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
    assert (found["device"], found["display"][1]) == ("binary", "Set temp 50°C   ")
    text = Path("pins.vcd").read_text(encoding="ascii")
    assert " D3_heater $end" in text
    assert " D9_display_E $end" in text
    assert text.count("\n#") > 1000


def test_what_leds_show_is_told(heatwright: Heatwright) -> None:
    words = f"simulate {EXAMPLES}/fabricator.yaml --for 4s"
    shown = {"enabled": "lit", "heating": "lit", "cooling": "dark", "communicating": "lit"}
    assert heatwright(f"{words} --json").json["lights"] == {"nozzle": shown}
    told = heatwright(words).out
    assert "LEDs of nozzle: enabled lit, heating lit, cooling dark, communicating lit\n" in told


def test_what_the_board_refuses_is_told(heatwright: Heatwright) -> None:
    """A master's write is answered by an exception, a host's line by a text."""
    lines = "{at: 2 s, send: M104 S400}, {at: 4 s, send: M104 S200}"
    Path("host.yaml").write_text(f"scenario: [{lines}, {{for: 6 s}}]", encoding="utf-8")
    words = f"simulate {EXAMPLES}/feeder.yaml --scenario host.yaml"
    (refused,) = heatwright(f"{words} --json").json["not_done"]
    assert refused["answer"] == "M104 is outside its limits; nothing was changed"
    assert 2 < refused["time_s"] < 2.1
    assert "at 2.0 s failed: M104 is outside its limits; nothing" in heatwright(words).out
    written = "{at: 2 s, write: {air.manual: true}}"  # of a loop that is off
    Path("master.yaml").write_text(f"scenario: [{written}, {{for: 6 s}}]", encoding="utf-8")
    words = f"simulate {EXAMPLES}/dryer.yaml --scenario master.yaml --json"
    (refused,) = heatwright(words).json["not_done"]
    assert refused["answer"] == "air.manual: exception 3"
    assert heatwright(f"{words} --model").json["not_done"] is None


def test_labels_of_events_a_second_apart_cover_no_other(tmp_path: Path) -> None:
    pressed = [*range(1, 8), *range(590, 599)]
    events = [f"{{at: {at} s, press: {'up' if at % 2 else 'select'}}}" for at in pressed]
    file = tmp_path / "x.yaml"
    file.write_text(f"scenario: [{', '.join(events)}, {{for: 10 min}}]", encoding="utf-8")
    controller = with_scenario(example("chamber"), file, None)
    figure = run_figure(run_model(controller, _PlainJob("")).trace, controller)
    figure.canvas.draw()
    boxes = [text.get_window_extent() for text in figure.axes[0].texts]
    assert len(boxes) == len(pressed)
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))


@pytest.mark.parametrize(("name", "algorithm"), ROWS)
def test_rows_equal_the_model_on_their_binaries(
    heatwright: Heatwright, name: str, algorithm: str
) -> None:
    command = f"compare {EXAMPLES}/{name}.yaml --algorithm {shlex.quote(algorithm)} --json"
    rows = heatwright(command).json["rows"]
    controller = example(name).controller
    assert len(rows) == [row.name for row in controller.comparison].count(algorithm)
    for row in rows:
        lasts_s = sum(event.for_s or 0 for event in row_scenario(controller))
        steps = round(lasts_s / controller.loops[row["loop"]].period_s)
        assert row["replay"]["mismatches"] == 0
        assert row["replay"]["ticks"] >= steps - 1
        assert fits(row["build"], BUILD)


def test_rows_of_several_loops_equal_the_model_on_their_binaries(heatwright: Heatwright) -> None:
    (row,) = heatwright(f"compare {printer_rows()} --algorithm PI --json").json["rows"]
    assert row["replay"]["mismatches"] == 0
    stepped_s = 440.0 - 0.5  # its start takes less
    assert row["replay"]["ticks"] >= int(stepped_s / 0.1) + int(stepped_s / 0.5), "of both loops"


@pytest.fixture(scope="module")
def loops(chamber: Controller) -> ClosedLoop:
    """The model in the binary's place: everything holds."""
    run = run_model(chamber, _PlainJob(""))
    return ClosedLoop(run, {"air": replay(chamber, run.trace.steps["air"])})


def failing(checks: Any) -> dict[str, str]:
    return {check.what: check.found for check in checks if not check.passed}


def asking(limits: dict[str, str] | None, sent: list[str]) -> Simulation:
    """Return a simulation of a spec, with other expectations, and a host's lines."""
    simulation = example("chamber").controller.simulated
    scenario = tuple(Event.model_validate({"at": "5 s", "send": line}) for line in sent)
    expect = Expect.model_validate(limits) if limits else None
    return simulation.model_copy(update={"expect": expect, "scenario": scenario})


@pytest.mark.parametrize(
    ("line", "code", "passed"),
    [("m112", 19, True), ("N5 M112*20", 19, True), ("M112", 6, False), ("M1120", 19, False)],
)
def test_a_stop_that_the_scenario_sends_may_be_latched(
    loops: ClosedLoop, line: str, code: int, passed: bool
) -> None:
    judged = replace(loops, run=replace(loops.run, faults={"air": ((12.5, code),)}))
    assert (not failing(run_checks(judged, asking(None, ["M104 S20", line])))) == passed


TRIPPED = "E06 TOO HOT at 12.5 s"
TIMES = "display: data_setup was below the data sheet 3 times"


@pytest.mark.parametrize(
    ("limits", "changes", "expected"),
    [
        ({"overshoot": "0.5 K", "steady": "0.5 K"}, {}, {}),  # a limit counts as kept
        ({"overshoot": "0.49 K"}, {}, {"air: overshoot": "0.5 K"}),
        ({"steady": "0.49 K"}, {}, {"air: steady error": "0.5 K"}),
        (None, {"faults": {"air": ((12.5, 6),)}}, {"air: no protection trips": TRIPPED}),
        (None, {"complaints": (TIMES,)}, {"chips keep to their data sheets": TIMES}),
    ],
)
def test_what_is_asked_of_a_run(
    loops: ClosedLoop, limits: Any, changes: dict[str, Any], expected: dict[str, str]
) -> None:
    judged = replace(loops, run=replace(loops.run, **changes))
    assert failing(run_checks(judged, asking(limits, []))) == expected


@pytest.mark.parametrize(
    ("changes", "failed"),
    [
        ({}, 0), ({"mismatches": 1}, 1), ({"restored": ("a fault",)}, 1),
        ({"unchecked": ("loop.secret",)}, 1),
        ({"unchecked": ("fault.time_s",)}, 0),  # inputs and the clock are not compared
    ],
)  # fmt: skip
def test_what_differs_from_the_model_fails(
    loops: ClosedLoop, changes: dict[str, Any], failed: int
) -> None:
    judged = replace(loops, replays={"air": replace(loops.replays["air"], **changes)})
    assert len(failing(replay_checks(judged))) == failed


@pytest.mark.parametrize(("length_s", "drawn_s"), [(60.0, 1800.0), (7200.0, 7200.0)])
def test_a_short_scenario_is_drawn_out_a_long_one_stays(length_s: float, drawn_s: float) -> None:
    found = long_enough(with_scenario(example("chamber"), None, length_s)).simulation
    assert found is not None
    assert found.scenario[-1].for_s == drawn_s


@pytest.mark.parametrize(
    ("event", "sent"),
    [("extrude: 1 mm/s", ["M105", None, None]), ("send: M104 S200", ["M104 S200", None])],
)
def test_a_silent_host_is_not_lost_where_a_scenario_is_drawn_out(
    tmp_path: Path, event: str, sent: list[str | None]
) -> None:
    """Keys may have switched the loop on, and 30 min are longer than its host may be silent."""
    file = tmp_path / "short.yaml"
    file.write_text(f"scenario: [{{at: 2 s, {event}}}, {{for: 60 s}}]", encoding="utf-8")
    found = long_enough(with_scenario(example("feeder"), file, None)).simulation
    assert found is not None
    assert [each.send for each in found.scenario] == sent


GOOD_FIGURE = Figure("busy waiting", "µs", 40.0, 100.0, "send_cell")
GOOD_FAULT = FaultResult("unplugged", "air", False, "sensor_no_answer", (), 4.9, 6.0, 0.9, 65)


@pytest.fixture
def tried(monkeypatch: pytest.MonkeyPatch) -> Any:
    def use(figure: Figure, fault: FaultResult) -> None:
        timing = Timing({"busy_us": figure}, (Cost("main", 1, 9, 0.1),), 0.99, 600.0)

        def try_all(controller: Controller, *_: object) -> Any:
            loops = closed_loop(controller, Path(), _PlainJob(""))
            return SimpleNamespace(loops=loops, timing=timing, faults=(fault,), known=1)

        built = BuildResult(Path("a.elf"), 6000, 200, 100, 32256, 2048, "")
        for name, stand_in in (
            ("engine.build_firmware", lambda *_: built),
            ("engine.program_of", lambda _: None),
            ("engine.try_all", try_all),
            ("trials.run_binary", lambda controller, _, job: run_model(controller, job)),
        ):
            monkeypatch.setattr(f"heatwright.cli.verify.{name}", stand_in)

    return use


@pytest.mark.parametrize(
    ("figure", "fault", "expected"),
    [
        ({}, {}, ""), ({"worst": 123.456}, {}, "busy waiting: 123.5 µs (limit: 100 µs)"),
        ({"worst": None}, {}, "busy waiting: – (limit: 100 µs)"),
        ({}, {"rule": None, "problems": ("no trip",)}, "fault unplugged: no trip"),
    ],
)  # fmt: skip
def test_verify_says_what_failed(
    heatwright: Heatwright, tried: Any, figure: Any, fault: Any, expected: str
) -> None:
    tried(replace(GOOD_FIGURE, **figure), replace(GOOD_FAULT, **fault))
    done = heatwright("verify chamber.yaml --report v.html", status=bool(expected))
    lines = done.out.splitlines()
    if expected.startswith("fault "):
        assert lines.pop(-2) == f"To repeat only these faults: --fault {GOOD_FAULT.fault}"
    *_, reason, verdict, page_name = lines
    page = Path("v.html").read_text(encoding="utf-8")
    said = "Failed: 1 of " if expected else "Passed: all "
    assert page_name == "v.html"
    assert verdict.capitalize().startswith(said)
    assert "with keys pressed" not in page, "there is no figure of them"
    assert said in page
    if expected:
        assert reason == expected
        assert expected in page
        assert heatwright("verify chamber.yaml --json", status=1).json["passed"] is False
