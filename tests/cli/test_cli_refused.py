"""What cannot be done is refused: status 2, the reason, nothing printed and nothing written."""

from pathlib import Path
from shutil import copyfile

import pytest
from rig.commands import Heatwright
from rig.specs import EXAMPLES

SCENARIOS = {
    "empty": ("", "empty:1:1: there is no scenario in this file. Write scenario: [ … ]."),
    "number": ("scenario: 1\n", "number:1:1: scenario: a list is needed here"),
    "list": ("- {for: 1 h}\n", "list:1:1: keys and values are needed here"),
    "unit": ("scenario:\n  - {for: 1}\n", "unit:2:6: scenario[0].for: 1 has no unit"),
    "endless": ("scenario:\n  - {at: 1 s, press: up}\n", "endless:1:1: scenario: "),
    "open": ("scenario: [", "open:1:1"),
    "other": ("scenario: []\nother: 1\n", "other:2:1: other: there is no such key"),
}
"""Files of scenarios, and what is said of them."""


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ("", "Usage:"),
        ("generat x.yaml", "Did you mean 'generate'?"),
        ("generate", "Missing argument 'SPEC'"),
        ("generate chamber.yaml --chekc", "'--check'"),
        ("generate none.yaml", "none.yaml: no such file or directory.\n"),
        ("generate .", ".: is a directory.\n"),
        ("init none/a.yaml", "none/a.yaml: no such file or directory.\n"),
        ("init oven.yaml", "oven.yaml: is there already"),
        ("init folder.yaml", "folder.yaml: is there already"),
        ("generate chamber.yaml -o oven.yaml", "oven.yaml is a file where a folder"),
        ("generate chamber.yaml -o oven.yaml/below", "oven.yaml/below"),
        ("generate chamber.yaml -o /proc/heatwright", "/proc/heatwright: "),
        ("build chamber.yaml -o oven.yaml", "oven.yaml: is a file"),
        ("simulate chamber.yaml --for 3", "3 has no unit"),
        ("simulate chamber.yaml --for '-1 s'", "-1 s is too small"),
        ("simulate chamber.yaml --plot x.pdf", "x.pdf: name it with .png or"),
        ("simulate chamber.yaml --csv none/x.csv", "there is no folder none"),
        ("simulate chamber.yaml --csv .", ".: is a folder"),
        ("simulate chamber.yaml --model --vcd x.vcd", "The model has no pins"),
        ("simulate chamber.yaml --display k.png", "There is no touch display to draw"),
        ("simulate kiln.yaml --display k.png --model", "The model has no display"),
        ("simulate kiln.yaml --display k.jpg", "name it with .png"),
        ("simulate kiln.yaml --display k.png --serial", "--serial goes with"),
        ("simulate bare.yaml --model", "bare.yaml: has no `simulation`"),
        ("verify bare.yaml", "bare.yaml: has no `simulation`"),
        ("verify chamber.yaml --core qemu", "'own', 'simavr'"),
        ("compare chamber.yaml", "chamber.yaml: has no `comparison`"),
        ("compare oven.yaml --algorithm none", "no row is called none; there are"),
        ("simulate chamber.yaml --scenario no.yaml", "no.yaml: no such file"),
        ("simulate chamber.yaml --model --scenario no.yaml --csv step.csv", "no such file"),
        *((f"simulate chamber.yaml --model --scenario {name}", reason)
          for name, (_, reason) in SCENARIOS.items()),
        ("identify", "Missing argument 'LOG'"),
        ("identify no.csv", "no.csv: no such file"),
        ("identify . --power 40W", "is a directory"),
        ("identify empty.csv --power 40W", "empty.csv: holds no rows of numbers"),
        ("identify step.csv", "step.csv: has the duty, not the power; say what full duty is"),
        ("identify step.csv --power 40", "40 has no unit"),
        ("identify step.csv --power 0W", "--power: must be above 0"),
        ("identify step.csv --power 40W --plot x.gif", "x.gif: name it with .png or .svg"),
        ("identify step.csv --power 40W --plot no/x.png", "there is no folder no"),
        ("identify step.csv --power 40W --columns time,x", "has no use for a column x"),
        ("identify step.csv --loop air", "--loop names a loop of a spec"),
        ("identify step.csv --spec oven.yaml --loop x", "oven.yaml: has no loop x; there are air"),
        ("identify step.csv --spec step.csv", "step.csv:1:"),
        ("tune no.yaml", "no.yaml: no such file"),
        ("tune bare.yaml", "bare.yaml: has no `simulation`"),
        ("tune chamber.yaml", "chamber.yaml: heater heater is switched on and off only"),
        ("tune oven.yaml --method relay", "Loop air does not tune itself"),
        ("tune oven.yaml --method ziegler", "'ziegler' is not one of"),
        ("tune oven.yaml --loop water", "oven.yaml: has no loop water; there are air."),
        ("tune oven.yaml --at 90C", "--at 90 °C: the loop's setpoints are 10 °C to 70 °C"),
        ("tune oven.yaml --at 15C", "15 °C is no warmer than the ambient"),
        ("tune oven.yaml --at 60", "60 has no unit"),
        ("tune oven.yaml --lambda 0s", "--lambda: must be above 0"),
        ("tune oven.yaml --plot tune.html", "name it with .png or .svg"),
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
    Path("folder.yaml").mkdir()

    def everything() -> dict[str, bytes]:
        return {path.name: path.read_bytes() for path in Path().rglob("*") if path.is_file()}

    there = everything()
    done = heatwright(words, status=2)
    assert done.out == ""
    assert reason in done.err
    assert everything() == there
