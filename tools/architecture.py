# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw the house and the way of the data from the code.

The house: which package imports which. The way: what the functions on it take and give. `--check`
tells whether the committed pictures are those of the code.
"""

import ast
import inspect
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

sys.modules.setdefault("schemdraw.backends.mpl", None)  # type: ignore[arg-type]
import schemdraw  # noqa: E402 - matplotlib takes a second, and is not needed for SVG
from schemdraw import elements, flow  # noqa: E402

from heatwright.generator import plan_firmware, render, write  # noqa: E402
from heatwright.generator.toolchain import build  # noqa: E402
from heatwright.sim.bench import bench  # noqa: E402
from heatwright.sim.replay import replay_all  # noqa: E402
from heatwright.sim.trace import StepLog  # noqa: E402
from heatwright.spec import load  # noqa: E402

ROOT = Path(__file__).parents[1]
PICTURES = ROOT / "docs" / "pictures"
PACKAGES = {
    "cli": ("the commands", 0),
    "generator": ("spec to files", -1),
    "sim": ("the binary's world", 1),
    "templates": ("the firmware, as C", -1),
    "spec": ("the language", 0),
}
"""What lives there, and how far left or right it is drawn; the code tells how high."""
WAY: tuple[tuple[Callable[..., Any], str], ...] = (
    (load, "spec"),
    (plan_firmware, "generator"),
    (render, "generator"),
    (write, "generator"),
    (build, "generator"),
    (bench, "sim"),
    (replay_all, "sim"),
)
WIDE, HIGH, APART = 3.6, 1.3, 1.5
_NAMED = re.compile(r"heatwright\.(\w+)")
_DECIMALS = re.compile(r"\d+\.\d{3,}")


def imports() -> dict[str, list[str]]:
    """Find, for each package, the others that its modules import or name."""
    found = {}
    for package in PACKAGES:
        names = {each for path in (ROOT / package).rglob("*.py") for each in _named(path)}
        found[package] = [each for each in PACKAGES if each in names - {package}]
    return found


def _named(path: Path) -> set[str]:
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        match node:
            case ast.ImportFrom(module=str(module), level=0):
                names |= {*_NAMED.findall(module)}
                if module == "heatwright":
                    names |= {each.name for each in node.names}
            case ast.Import():
                names |= {name for each in node.names for name in _NAMED.findall(each.name)}
            case ast.Call(args=[ast.Constant(value=str(text)), *_]):
                names |= {*_NAMED.findall(text)}
    return names


def levels(found: Mapping[str, Sequence[str]]) -> dict[str, int]:
    """Put each package above all that it imports."""

    def level(package: str, above: tuple[str, ...] = ()) -> int:
        if package in above:
            sys.exit(f"{' imports '.join((*above, package))}: there is no house like that.")
        return max((level(each, (*above, package)) + 1 for each in found[package]), default=0)

    return {package: level(package) for package in found}


def house() -> str:
    """Draw which package imports which."""
    found = imports()
    floors = levels(found)
    drawing = _drawing()
    places = {
        package: (column * (WIDE + APART), floors[package] * (HIGH + APART))
        for package, (_, column) in PACKAGES.items()
    }
    for package, (about, _) in PACKAGES.items():
        text = f"{package}/\n{about}"
        drawing += flow.Box(w=WIDE, h=HIGH).at(places[package]).anchor("SW").label(text)
    for package, others in found.items():
        for other in others:
            _arrow(drawing, places[package], places[other])
    return _printed(drawing)


def _arrow(drawing: Any, start: tuple[float, float], end: tuple[float, float]) -> None:
    """Lead from the lower edge of one box to the upper edge of another, beside its fellows."""
    aside = (end[0] > start[0]) - (end[0] < start[0])
    begin = (start[0] + WIDE * (0.5 + 0.25 * aside), start[1])
    until = (end[0] + WIDE * (0.5 - 0.25 * aside), end[1] + HIGH)
    drawing += elements.Line(arrow="->").at(begin).to(until)


def way() -> str:
    """Draw what each step takes and gives, by its own annotations."""
    drawing = _drawing()
    for number, (function, package) in enumerate(WAY):
        taken, given = _types(function)
        y = -number * (HIGH + 0.9)
        text = f"{function.__name__}\n{package}/"
        drawing += flow.Box(w=WIDE, h=HIGH).at((0, y)).anchor("SW").label(text)
        drawing += (
            elements.Label()
            .at((WIDE + 0.3, y + 0.85))
            .label(f"takes {taken}", halign="left", fontsize=10)
        )
        drawing += (
            elements.Label()
            .at((WIDE + 0.3, y + 0.4))
            .label(f"gives {given}", halign="left", fontsize=10)
        )
        if number:
            drawing += (
                elements.Line(arrow="->").at((WIDE / 2, y + HIGH + 0.9)).to((WIDE / 2, y + HIGH))
            )
    drawing += elements.Gap().at((WIDE + 13, 0)).to((WIDE + 13.1, 0))
    return _printed(drawing)


def _types(function: Callable[..., Any]) -> tuple[str, str]:
    signature = inspect.signature(function)
    needed = [
        _short(each.annotation)
        for each in signature.parameters.values()
        if each.default is each.empty
    ]
    return ", ".join(needed), _short(signature.return_annotation)


def _short(annotation: object) -> str:
    text = annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)
    text = text.replace(inspect.formatannotation(StepLog), "StepLog")
    return re.sub(r"\b(?:\w+\.)+(?=\w)", "", text).replace("str | PathLike[str]", "Path")


def _drawing() -> Any:
    schemdraw.use("svg")
    schemdraw.svgconfig.text = "text"
    drawing = schemdraw.Drawing(show=False)
    drawing.config(
        unit=1.1, inches_per_unit=0.5, fontsize=11, font="sans-serif", lw=1.2, bgcolor="white"
    )
    return drawing


def _printed(drawing: Any) -> str:
    text = drawing.get_imagedata("svg").decode("utf-8")
    text = _DECIMALS.sub(lambda found: f"{float(found[0]):.2f}", text)
    return str(text).replace("><", ">\n<") + "\n"


PAGES = {"house.svg": house, "way.svg": way}


def main() -> int:
    """Write the pictures, or tell which are no longer those of the code."""
    stale = []
    for name, draw in PAGES.items():
        file, text = PICTURES / name, draw()
        if "--check" not in sys.argv:
            file.write_text(text, encoding="utf-8")
        elif not file.is_file() or file.read_text("utf-8") != text:
            stale.append(name)
    if stale:
        sys.stderr.write(f"{', '.join(stale)}: not of this code; python tools/architecture.py\n")
    return bool(stale)


if __name__ == "__main__":
    sys.exit(main())
