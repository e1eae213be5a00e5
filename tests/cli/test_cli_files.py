"""What reads and writes files: check, init, generate, schema; simulate and compare on the model."""

import errno
import os
import re
import xml.etree.ElementTree as ET
from io import StringIO
from pathlib import Path
from shutil import copyfile
from unittest.mock import Mock

import pytest
from rich.console import Console
from rig.commands import Heatwright, changed, printer_rows
from rig.firmware import EXAMPLES, example

from heatwright.cli.tables import table
from heatwright.cli.tune import tabled as tuned
from heatwright.sim.plots.plot_data import LOOPS


def test_all_problems_of_all_files(heatwright: Heatwright) -> None:
    done = heatwright("check --quick chamber.yaml oven.yaml")
    chamber, air, effort, oven, *_ = done.out.splitlines()
    assert effort == "  air: effort_high can never trip, effort_low can trip from 41 °C on"
    assert (chamber, oven, done.err) == ("chamber.yaml: good", "oven.yaml: good", "")
    assert air.startswith("  air: 240 W, a reserve of ")
    text = Path("chamber.yaml").read_text(encoding="utf-8")
    Path("one.yaml").write_text(text.replace("period: 1 s", "period: 1"), encoding="utf-8")
    Path("two.yaml").write_text(text.replace("maximum: 85 °C", "maximm: 85 °C"), encoding="utf-8")
    told = heatwright("check --quick one.yaml chamber.yaml none.yaml . two.yaml", status=2).out
    for expected in (
        "chamber.yaml: good\n", "none.yaml:1:1: the file cannot be read: no such file",
        ".:1:1: the file cannot be read: is a directory",
        "one.yaml:21:5: loops.air.period: 1 has no unit",
        "two.yaml:26:7: loops.air.protection.maximm: there is no such key",
    ):  # fmt: skip
        assert expected in told


def test_problems_as_json_and_from_the_other_commands(heatwright: Heatwright) -> None:
    Path("bad.yaml").write_text("heatwright: 2\n", encoding="utf-8")
    found = heatwright("check --quick chamber.yaml bad.yaml --json", status=2).json
    assert [each["file"] for each in found["good"]] == ["chamber.yaml"]
    first = found["problems"][0]
    assert (first["file"], first["line"], first["column"]) == ("bad.yaml", 1, 1)
    assert set(first) == {"file", "line", "column", "path", "reason", "remedy"}
    reported = heatwright("check bad.yaml", status=2).out
    of_a_spec = ("generate", "build", "simulate", "verify", "compare", "tune", "size", "campaign")
    for words in (*(f"{each} bad.yaml" for each in of_a_spec), "identify bad.yaml --spec bad.yaml"):
        done = heatwright(words, status=2)
        assert (done.out, done.err) == ("", reported)
        failed = heatwright(f"{words} --json", status=2).json
        assert failed == {"status": 2, "error": reported.strip(), "problems": found["problems"]}


def test_what_trips_on_a_machine_that_is_well_is_told_with_a_number_that_does(
    heatwright: Heatwright,
) -> None:
    name = changed("hotplate", "within: 60 s", "within: 40 s")
    assert heatwright(f"check {name} --quick").out.startswith(f"{name}: good\n")
    (found,) = heatwright(f"check {name} --json", status=2).json["problems"]
    assert found["path"] == "loops.plate.protection.heating.within"
    assert ", with hysteresis 3 K, as keys may set it: " in found["reason"]
    weak = Path(name).read_text(encoding="utf-8")
    mended = weak.replace("within: 40 s", found["remedy"].removeprefix("Write "))
    Path(name).write_text(mended, encoding="utf-8")
    done = heatwright(f"check {name}")
    assert (done.out.splitlines()[0], done.err) == (
        f"{name}: good",
        "Running the scenario …\nRunning plate …\n"
        "Running plate with hysteresis 0.5 K …\nRunning plate with hysteresis 3 K …\n",
    )


def test_watching_checks_again_at_each_save(
    heatwright: Heatwright, monkeypatch: pytest.MonkeyPatch
) -> None:
    good = Path("oven.yaml").read_text(encoding="utf-8")
    saves = iter((None, good.replace("board: uno", "board: duo"), None, good))

    def wait(_: float) -> None:
        text = next(saves, "")
        if text == "":
            raise KeyboardInterrupt
        if text is not None:
            Path("oven.yaml").write_text(text, encoding="utf-8")

    monkeypatch.setattr("heatwright.cli.commands.check.sleep", wait)
    done = heatwright("check --quick --watch oven.yaml", status=130)
    told = [line for line in done.out.splitlines() if line.startswith("oven.yaml:")]
    assert [line.startswith("oven.yaml: good") for line in told] == [True, False, True]
    assert "'duo' is not a board" in told[1]
    assert done.err == 3 * "Watching …\n" + "Interrupted.\n"


@pytest.mark.parametrize("words", ["oven.yaml --json", "-"])
def test_what_cannot_be_watched_is_refused(heatwright: Heatwright, words: str) -> None:
    assert "--watch " in heatwright(f"check --watch {words}", status=2).err


def test_a_started_spec_runs_in_the_model_as_it_expects(heatwright: Heatwright) -> None:
    assert heatwright("init 'My Kiln-2.yaml'").out.endswith("heatwright check 'My Kiln-2.yaml'\n")
    assert "verify 'My Kiln-2.yaml' " in Path("My Kiln-2.yaml").read_text(encoding="utf-8")
    for command in ("check", "generate"):
        heatwright(f"{command} 'My Kiln-2.yaml'")
    assert Path("generated/my_kiln_2/platformio.ini").is_file()
    found = heatwright("simulate 'My Kiln-2.yaml' --model --json").json["loops"]["air"]
    assert found["faults"] == []
    assert found["closed_loop"]["overshoot"] <= 2
    assert found["closed_loop"]["steady_max"] - found["closed_loop"]["steady_min"] <= 1


@pytest.mark.parametrize("name", ["while.yaml", "1.yaml", "···.yaml", "x" * 100 + ".yaml"])
def test_a_file_without_a_name_gives_a_good_spec(heatwright: Heatwright, name: str) -> None:
    heatwright(f"init {name}")
    heatwright(f"check {name}")


def test_generate_writes_where_one_would_look(heatwright: Heatwright) -> None:
    assert heatwright("generate chamber.yaml").out.startswith("generated/chamber: ")
    assert "all up to date" in heatwright("generate chamber.yaml").out
    heatwright("generate chamber.yaml --check")
    assert heatwright("schema --json").json["title"] == "heatwright"


def test_what_differs_is_named_both_ways(heatwright: Heatwright) -> None:
    heatwright("generate chamber.yaml -o out")
    Path("out/src/main.c").rename("out/src/old.c")
    told = heatwright("generate chamber.yaml -o out --check", status=1).out
    assert told.splitlines() == ["out/src/main.c: missing", "out/src/old.c: extra"]
    found = heatwright("generate chamber.yaml -o out --check --json", status=1).json
    assert {"path": "src/old.c", "state": "extra"} in found["differences"]
    assert not Path("out/src/main.c").exists()
    told = heatwright("generate chamber.yaml -o out").err
    assert told == "out/src/old.c: no longer generated; delete it.\n"
    assert heatwright("generate chamber.yaml -o out --json").json["left_over"] == ["src/old.c"]


def test_a_full_disk_names_the_file(
    heatwright: Heatwright, monkeypatch: pytest.MonkeyPatch
) -> None:
    full = Mock(side_effect=OSError(errno.ENOSPC, "No space left on device"))
    monkeypatch.setattr("heatwright.sim.trace.Trace._rows", full)
    done = heatwright("simulate chamber.yaml --model --for 10s --csv x.csv", status=2)
    assert done.err.splitlines()[-1] == "x.csv: cannot be written: no space left on device."
    assert not Path("x.csv").exists()
    assert [path for path in Path().iterdir() if path.name.startswith(".")] == []


PNG = b"\x89PNG\r\n\x1a\n"


def test_a_run_is_told_in_figures(heatwright: Heatwright) -> None:
    done = heatwright("simulate chamber.yaml --model")
    assert "setpoint [°C]" in done.out
    assert "30 min simulated in" in done.out
    assert done.err == "Simulating the model …\n"
    found = heatwright("simulate chamber.yaml --model --json").json
    assert (found["spec"], found["device"]) == ("chamber.yaml", "model")
    assert found["loops"]["air"]["closed_loop"]["maximum"] == 50.5
    assert (found["loops"]["air"]["faults"], found["display"]) == ([], None)


@pytest.mark.parametrize("width", [30, 50, 80, 110, 200])
def test_no_head_and_no_number_of_a_table_is_cut(width: int) -> None:
    cells = [f"{number}.25" for number, _ in enumerate(tuned.COLUMNS[1:], 10)]
    out = Console(file=StringIO(), width=width)
    out.print(table(tuned.COLUMNS, [("as it is", *cells), ("simc", *cells)]))
    told = out.file.getvalue()  # type: ignore[attr-defined]
    assert all(word in told for word in " ".join(tuned.COLUMNS).split())
    assert all(told.count(cell) == 2 for cell in cells)


@pytest.mark.parametrize(
    ("words", "length_s", "figures"),
    [
        ("--for 40min", 2400, {}),
        ("--for '5 s'", 5, {"maximum": 20}),  # the key is pressed after the end
        ("--scenario cold.yaml", 120, {"energy_J": 0}),
        ("--scenario cold.yaml --for 1min", 60, {"energy_J": 0}),
    ],
)
def test_what_is_done_and_for_how_long(
    heatwright: Heatwright, words: str, length_s: float, figures: dict[str, float]
) -> None:
    cold = "scenario:\n  - {at: 1 s, press: down}\n  - {for: 2 min}\n"
    Path("cold.yaml").write_text(cold, encoding="utf-8")
    found = heatwright(f"simulate chamber.yaml --model --json {words}").json
    assert found["speed"]["simulated_s"] == pytest.approx(length_s, abs=1)
    assert figures.items() <= found["loops"]["air"]["closed_loop"].items()


def drawn(heatwright: Heatwright, title: str, picture: str) -> str:
    spec = changed("chamber", "Air heater for a 3D-printer enclosure", f"'{title}'", count=2)
    done = heatwright(f"simulate {spec} --model --for 1min --plot {picture}")
    assert done.out.splitlines()[-1] == picture
    return "" if picture.endswith("png") else Path(picture).read_text(encoding="utf-8")


def test_pictures_are_of_their_kinds_and_text_stays_text(heatwright: Heatwright) -> None:
    mathematics = "[bold]$\\frac{1}$ ^_"
    drawn(heatwright, mathematics, "run.png")
    assert Path("run.png").read_bytes().startswith(PNG)
    root = ET.fromstring(drawn(heatwright, mathematics, "run.svg"))  # noqa: S314 - our own
    assert root.tag.endswith("svg")
    page = drawn(heatwright, "</title></script><script>alert(1)</script>", "run.html")
    assert page.startswith("<!doctype html>")
    assert "<script>alert" not in page
    assert "http" not in page.replace("http://www.w3.org", ""), "it needs nothing else"


def test_a_touch_display_is_drawn_and_a_plain_shield_is_not(heatwright: Heatwright) -> None:
    heatwright("simulate chamber.yaml --for 5s --plot c.html")
    assert "<img" not in Path("c.html").read_text(encoding="utf-8")
    done = heatwright(f"simulate {EXAMPLES}/kiln.yaml --for 5s --display k.png --plot k.html")
    assert "k.png" in done.out.splitlines()
    assert Path("k.png").read_bytes().startswith(PNG)
    page = Path("k.html").read_text(encoding="utf-8")
    assert len(re.findall(r'<img class="screen" src="data:image/png;base64,[\w+/]+=*"', page)) == 1


def test_a_comparison_stands_beside_the_published_figures(heatwright: Heatwright) -> None:
    told = heatwright("compare oven.yaml --model --algorithm relay").out
    ours, published, residual = told.rstrip().splitlines()[-3:]
    assert ours.split()[:4] == ["relay,", "50", "°C", "52.31"]
    assert published.split()[:3] == ["published", "52.20", "+2.20"]
    assert residual.split() == ["residual", "+0.11", "-0.12", "…", "+0.10"]


def test_a_comparison_as_json_and_as_a_page(heatwright: Heatwright) -> None:
    found = heatwright("compare oven.yaml --model --algorithm pid --json --plot c.html").json
    assert {"proportional", "PID"} <= {row["name"] for row in found["rows"]}
    row = found["rows"][0]
    assert row["published"] == {"maximum": 50.5, "steady_min": 48.7, "steady_max": 49.2}
    residual = {"maximum": 0.0, "steady_min": 0.425, "steady_max": -0.0125}
    assert row["residual"] == pytest.approx(residual, abs=1e-3)
    assert (row["build"], row["replay"], row["audible"]) == (None, None, True)
    assert "figure class=" in Path("c.html").read_text(encoding="utf-8")


def test_a_comparison_as_json_of_several_loops(heatwright: Heatwright) -> None:
    spec = printer_rows()
    found = heatwright(f"compare {spec} --model --json --plot c.html").json
    rows = {(row["loop"], row["name"]): row for row in found["rows"]}
    pairs = [("hotend", "relay"), ("hotend", "this spec"), ("bed", "PI"), ("bed", "this spec")]
    assert list(rows) == pairs
    assert rows["hotend", "this spec"]["setpoint"] == 200, "its own 0 °C is off"
    assert 199 < rows["hotend", "relay"]["closed_loop"]["maximum"] < 205
    assert rows["bed", "PI"]["steady_error"] > rows["bed", "this spec"]["steady_error"]
    page = Path("c.html").read_text(encoding="utf-8")
    for name, colour in (("hotend: relay, 200", "var(--accent)"), ("bed: PI, 60", LOOPS[1])):
        assert f'"name":"{name} °C","colour":"{colour}"' in page
    told = heatwright(f"compare {spec} --model --loop bed --algorithm pid --plot c.svg").out
    assert re.findall(r"^ (\w+: .*?),", told, re.MULTILINE) == ["bed: PI", "bed: this spec"]
    drawn = re.findall("<!-- (.*?) -->", Path("c.svg").read_text(encoding="utf-8"))
    assert [text for text in drawn if text.endswith("simulated")] == ["bed simulated"]
    refused = heatwright(f"compare {spec} --loop bad", status=2).err
    assert refused.endswith("has no loop bad; there are hotend, bed.\n")


COMPARED = sorted(
    path.stem for path in EXAMPLES.glob("*.yaml") if "\ncomparison:" in path.read_text("utf-8")
)


@pytest.mark.parametrize("name", COMPARED)
def test_all_rows_are_drawn_beside_each_other(heatwright: Heatwright, name: str) -> None:
    """An author's own law and ours: a curve for each row of an example, by its name."""
    rows = example(name).controller.comparison
    heatwright(f"compare {EXAMPLES}/{name}.yaml --model --plot c.html")
    page = Path("c.html").read_text(encoding="utf-8")
    drawn = [each for each in re.findall('"name":"(.*?)"', page) if "this spec" not in each]
    assert drawn == [f"{row.name}, {row.setpoint_c:g} °C" for row in rows]


SCENARIOS = {
    "empty": ("", "empty:1:1: there is no scenario in this file. Write scenario: [ … ]."),
    "number": ("scenario: 1\n", "number:1:1: scenario: a list is needed here"),
    "list": ("- {for: 1 h}\n", "list:1:1: keys and values are needed here"),
    "unit": ("scenario:\n  - {for: 1}\n", "unit:2:6: scenario[0].for: 1 has no unit"),
    "endless": ("scenario:\n  - {at: 1 s, press: up}\n", "endless:1:1: scenario: "),
    "open": ("scenario: [", "open:1:1"),
    "other": ("scenario: []\nother: 1\n", "other:2:1: other: there is no such key"),
}  # files of scenarios, and what is said of them


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ("", "Usage:"), ("generat x.yaml", "Did you mean 'generate'?"),
        ("generate", "Missing argument 'SPEC'"),
        ("generate none.yaml", "none.yaml: cannot be read: no such file or directory."),
        ("generate .", ".: cannot be read: is a directory."), ("generate ''", "the name is empty"),
        ("generate chamber.yaml -o ''", "the name is empty"),
        ("generate pipe", "pipe: cannot be read: it is no regular file."),
        ("init none/a.yaml", "none/a.yaml: cannot be written: no such file or directory."),
        ("init oven.yaml", "oven.yaml: exists already"),
        ("generate chamber.yaml -o oven.yaml", "oven.yaml is a file where a folder"),
        ("generate chamber.yaml -o oven.yaml/below", "oven.yaml/below"),
        ("generate chamber.yaml -o /proc/heatwright", "/proc/heatwright: cannot be written: "),
        ("build chamber.yaml -o oven.yaml", "oven.yaml: is a file"),
        ("build chamber.yaml -o piped", "piped/chamber.hex: is a pipe"),
        ("simulate chamber.yaml --csv pipe", "pipe: is a pipe"),
        ("simulate chamber.yaml --model --scenario pipe", "pipe: cannot be read: it is no regular"),
        ("simulate chamber.yaml --for 3", "3 has no unit"),
        ("simulate chamber.yaml --for '-1 s'", "-1 s is too small"),
        ("simulate chamber.yaml --plot x.pdf", "x.pdf: the name must end with .png or"),
        ("simulate chamber.yaml --csv none/x.csv", "there is no folder none"),
        ("simulate chamber.yaml --csv .", ".: is a folder"),
        ("simulate chamber.yaml --model --vcd x.vcd", "The model has no pins"),
        ("simulate chamber.yaml --display k.png", "There is no touch display to draw"),
        ("simulate kiln.yaml --display k.png --model", "The model has no display"),
        ("simulate kiln.yaml --display k.jpg", "the name must end with .png"),
        ("simulate kiln.yaml --display k.png --serial", "--serial can be"),
        ("simulate kiln.yaml --model --serial", "--serial can be combined with --speed"),
        ("simulate chamber.yaml --serial", "No interface of this spec listens to a serial port"),
        ("simulate bare.yaml --model", "bare.yaml: has no `simulation`"),
        ("verify bare.yaml", "bare.yaml: has no `simulation`"),
        ("verify chamber.yaml --elf pipe", "pipe: cannot be read: it is no regular file"),
        ("verify chamber.yaml --core qemu", "'own', 'simavr'"),
        ("compare chamber.yaml", "chamber.yaml: has no `comparison`"),
        ("compare oven.yaml --algorithm none", "no row is called none; there are"),
        ("simulate chamber.yaml --model --scenario no.yaml --csv step.csv", "no such file"),
        *((f"simulate chamber.yaml --model --scenario {name}", reason)
          for name, (_, reason) in SCENARIOS.items()),
        ("identify no.csv", "no.csv: cannot be read: no such file"),
        ("identify pipe --power 40W", "pipe: cannot be read: it is no regular file"),
        ("identify empty.csv --power 40W", "empty.csv: has no rows of numbers"),
        ("identify step.csv", "step.csv: has the duty, not the power; say what full duty is"),
        ("identify step.csv --power 40", "40 has no unit"),
        ("identify step.csv --power 0W", "--power: must be above 0"),
        ("identify step.csv --power 40W --plot x.gif", "the name must end with .png or .svg"),
        ("identify step.csv --power 40W --columns time,x", "cannot have a column x"),
        ("identify step.csv --loop air", "--loop names a loop of a spec"),
        ("identify step.csv --spec oven.yaml --loop x", "oven.yaml: has no loop x; there are air"),
        ("identify step.csv --spec step.csv", "step.csv:1:"),
        (f"identify step.csv --spec {EXAMPLES}/barrel.yaml", "barrel, die. Name the loop of this"),
        ("tune bare.yaml", "bare.yaml: has no `simulation`"),
        ("tune chamber.yaml", "chamber.yaml: heater heater is only switched on and off"),
        ("tune oven.yaml --method relay", "Loop air cannot tune itself"),
        ("tune oven.yaml --method ziegler", "'ziegler' is not one of"),
        ("tune oven.yaml --loop water", "oven.yaml: has no loop water; there are air."),
        ("tune oven.yaml --at 90C", "--at 90 °C: the loop's setpoints are 10 °C to 70 °C"),
        ("tune oven.yaml --at 15C", "15 °C is not above the ambient"),
        ("tune oven.yaml --lambda 0s", "--lambda: must be above 0"),
        ("tune oven.yaml --plot tune.html", "the name must end with .png or .svg"),
    ],
)  # fmt: skip
def test_what_cannot_be_done(heatwright: Heatwright, words: str, reason: str) -> None:
    copyfile(EXAMPLES / "kiln.yaml", "kiln.yaml")
    text = Path("oven.yaml").read_text("utf-8")
    given = {name: scenario for name, (scenario, _) in SCENARIOS.items()}
    given |= {"bare.yaml": text[: text.index("# The oven itself")], "empty.csv": ""}
    given["step.csv"] = "time [s],temperature [°C],duty [%]\n0,20,0\n1,20,100\n2,21,100\n"
    for name, content in given.items():
        Path(name).write_text(content, encoding="utf-8")
    Path("piped").mkdir()
    for pipe in ("pipe", "piped/chamber.hex"):
        os.mkfifo(pipe)

    def everything() -> dict[str, bytes]:
        return {path.name: path.read_bytes() for path in Path().rglob("*") if path.is_file()}

    there = everything()
    done = heatwright(words, status=2)
    assert done.out == ""
    assert reason in done.err
    failed = heatwright(f"{words} --json", status=2).json
    assert failed["status"] == 2
    assert reason in failed["error"]
    assert everything() == there
