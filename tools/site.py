# SPDX-License-Identifier: GPL-3.0-or-later
"""Build the documents as a site: README, docs/, a page for each kind, the schema."""

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from kind_pages import page, uses

from heatwright.cli.contract import UNIONS
from heatwright.cli.firmware import build_firmware
from heatwright.cli.talk import talk
from heatwright.sim.binary.elf import Elf
from heatwright.spec import kinds, load
from heatwright.spec.boards import BOARDS
from heatwright.spec.loading.schema import schema

ROOT = Path(__file__).parents[1]
PAGES = ROOT / "build" / "site-pages"
EXAMPLES = ROOT / "spec" / "examples"
WHOLE = ("docs", "LICENSES", "generated/kiln")
OUTSIDE = tuple(f"examples/{name}" for name in ("i2c_lcd", "max31865"))
SINGLE = (
    *("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "LICENSE"),
    *(f"{folder}/README.md" for folder in OUTSIDE),
)
FOLDERS = re.compile(rf"\]\(((?:\.\./)?(?:spec/examples|{'|'.join(OUTSIDE)}))\)")
"""Links to a folder; a site has pages."""
SCHEMA = "heatwright.schema.json"


def main() -> int:
    """Lay the pages out as they lie in the tree, so that each link leads where it leads there."""
    shutil.rmtree(PAGES, ignore_errors=True)
    for name in WHOLE:
        shutil.copytree(ROOT / name, PAGES / name)
    for name in SINGLE:
        (PAGES / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, PAGES / name)
    for path in PAGES.rglob("*.md"):
        text = path.read_text(encoding="utf-8")
        path.write_text(FOLDERS.sub(r"](\1/README.md)", text), encoding="utf-8")
    _examples()
    described = schema()
    (PAGES / SCHEMA).write_text(json.dumps(described, indent=2, ensure_ascii=False), "utf-8")
    _write_kinds(described)
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--clean"]
    quiet = os.environ | {"NO_MKDOCS_2_WARNING": "1"}
    return subprocess.run(command, cwd=ROOT, env=quiet, check=False).returncode  # noqa: S603


def _examples() -> None:
    """Write a page for each example."""
    folder = PAGES / "spec" / "examples"
    folder.mkdir(parents=True)
    rows = []
    for path in sorted(EXAMPLES.glob("*.yaml")):
        controller = load(path).controller
        title = controller.identity.title or controller.identity.name
        text = path.read_text(encoding="utf-8")
        shutil.copy(path, folder)
        (folder / f"{path.stem}.md").write_text(f"# {title}\n\n```yaml\n{text}```\n", "utf-8")
        rows.append(f"| [{path.stem}]({path.stem}.md) | {title} | {controller.identity.board} |")
    head = "# Examples\n\n| spec | machine | board |\n|---|---|---|\n"
    (folder / "README.md").write_text(head + "\n".join(rows) + "\n", encoding="utf-8")


def _write_kinds(described: dict[str, Any]) -> None:
    """Write a page for each kind, with its picture."""
    folder = PAGES / "kinds"
    folder.mkdir()
    found, keys = uses(EXAMPLES), dict(_kinds(described))
    with talk() as shown:
        built = build_firmware(load(EXAMPLES / "chamber.yaml"), shown.begin("Building chamber"))
    program = Elf(built.elf)
    roles = {role: [*kinds(union)] for role, union in UNIONS.items()} | {"board": [*BOARDS]}
    listed = ["# Kinds"]
    for role, names in roles.items():
        listed.append(f"## {role.capitalize()}s")
        listed.append("\n".join(f"- [{kind}]({kind}.md)" for kind in sorted(names)))
        for kind in names:
            text, pictures = page(role, kind, found.get((role, kind)), keys.get(kind), program)
            (folder / f"{kind}.md").write_text(text, encoding="utf-8")
            for name, picture in pictures.items():
                (folder / name).write_bytes(picture)
    (folder / "README.md").write_text("\n\n".join(listed) + "\n", encoding="utf-8")


def _kinds(described: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Find the models that have a kind."""
    for definition in described["$defs"].values():
        kind = definition["properties"].get("kind", {}).get("const")
        if kind is not None:
            yield kind, definition


if __name__ == "__main__":
    sys.exit(main())
