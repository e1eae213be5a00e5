"""The documents as a site: built without a warning, with a page for each kind and the schema. The
pictures of the house and of the way of the data are those of the code, whose docstrings have one
dialect."""

import ast
import json
import re
import sys

import yaml
from rig.firmware import ROOT, finished

from heatwright.cli.contract import UNIONS
from heatwright.spec import BOARDS, kinds
from heatwright.spec.loading.schema import schema

SITE, PAGES = ROOT / "build" / "site", ROOT / "build" / "site-pages"
PICTURES = {"svg": ("sensor", "output", "interface"), "png": ("algorithm", "plant")}
"""The roles whose pages show a wiring, and those that show a run."""
MKDOCS = [sys.executable, "-m", "mkdocs", "build", "--strict"]


def test_it_is_built_strictly() -> None:
    done = finished([sys.executable, "tools/site.py"], cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr
    assert json.loads((SITE / "heatwright.schema.json").read_text("utf-8")) == schema()
    known = {kind for union in UNIONS.values() for kind in kinds(union)}
    assert known | {*BOARDS} == {path.stem for path in (PAGES / "kinds").glob("*.md")} - {"README"}
    for kind in known:
        text = (PAGES / "kinds" / f"{kind}.md").read_text("utf-8")
        heads = re.findall("^## (.*)", text, re.MULTILINE)
        assert heads[-3:] == ["Keys", "What fails, and what trips", "Example"], kind
        (example,) = re.findall("```yaml\n(.*?)```", text, re.DOTALL)
        assert f"kind: {kind}" in example
        assert yaml.safe_load(example)
    for suffix, roles in PICTURES.items():
        drawn = {path.stem for path in (PAGES / "kinds").glob(f"*.{suffix}")}
        assert drawn == {kind for role in roles for kind in kinds(UNIONS[role])}
    sensor = (PAGES / "kinds" / "ds18b20.md").read_text("utf-8")
    assert "| `never_converts` | E01, E02, " in sensor
    assert "| `watchdog" not in sensor
    pages = {path.stem for path in (SITE / "docs").glob("*.html")}
    assert pages == {path.stem for path in (ROOT / "docs").glob("*.md")}
    outside = [
        path.name
        for path in SITE.rglob("*.html")
        if 'src="http' in path.read_text("utf-8") or "fonts.g" in path.read_text("utf-8")
    ]
    assert outside == []
    page = PAGES / "docs" / "ci.md"
    page.write_text(page.read_text("utf-8") + "[nowhere](nowhere.md)\n", encoding="utf-8")
    dead = finished(MKDOCS, cwd=ROOT)
    assert dead.returncode != 0
    assert "nowhere.md" in dead.stderr


FOLDERS = "cli", "examples", "generated", "generator", "sim", "spec", "templates", "tests", "tools"
SECTION = re.compile(
    "(?m)^ *(Args|Arguments|Attributes|Examples?|Notes?|Parameters|Raises|Returns|Yields):?$"
)


def test_docstrings_have_no_sections() -> None:
    trees = {
        path: ast.parse(text)
        for folder in FOLDERS
        for path in (ROOT / folder).rglob("*.py")
        if SECTION.search(text := path.read_text("utf-8"))
    }
    found = [
        f"{path.relative_to(ROOT)}: {heading[0]}"
        for path, tree in trees.items()
        for node in ast.walk(tree)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef)
        and (heading := SECTION.search(ast.get_docstring(node) or ""))
    ]
    assert found == [], "CONTRIBUTING.md, Style"


TOOL = ROOT / "tools" / "architecture.py"


def test_they_are_of_this_code() -> None:
    done = finished([sys.executable, TOOL, "--check"])
    assert done.returncode == 0, done.stderr


def test_an_arrow_more_is_seen_and_a_circle_refused() -> None:
    words = "import architecture as a; found = a.imports(); before = a.house()\n{}"
    more = "found['templates'] = ['spec']; a.imports = lambda: found; assert a.house() != before"
    circle = "found['spec'] = ['sim']; a.levels(found)"
    for line, status in ((more, 0), (circle, 1)):
        done = finished([sys.executable, "-c", words.format(line)], cwd=TOOL.parent)
        assert done.returncode == status, done.stderr
    assert "sim imports spec imports sim" in done.stderr or "spec imports sim" in done.stderr
