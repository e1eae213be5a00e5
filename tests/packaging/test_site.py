"""The documents as a site: built without a warning, with a page for each kind and the schema."""

import json
import subprocess
import sys
from pathlib import Path

from heatwright.spec import Algorithm, Interface, Output, Sensor, kinds
from heatwright.spec.loading.schema import schema

ROOT = Path(__file__).parents[2]
SITE, PAGES = ROOT / "build" / "site", ROOT / "build" / "site-pages"
MKDOCS = [sys.executable, "-m", "mkdocs", "build", "--strict"]


def test_it_is_built_strictly() -> None:
    done = subprocess.run(
        [sys.executable, "tools/site.py"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert json.loads((SITE / "heatwright.schema.json").read_text("utf-8")) == schema()
    known = {kind for union in (Sensor, Output, Algorithm, Interface) for kind in kinds(union)}
    assert known - {path.stem for path in (SITE / "kinds").glob("*.html")} == set()
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
    dead = subprocess.run(MKDOCS, cwd=ROOT, capture_output=True, text=True, check=False)
    assert dead.returncode != 0
    assert "nowhere.md" in dead.stderr
