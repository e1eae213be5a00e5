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

from heatwright.spec import load
from heatwright.spec.loading.schema import schema

ROOT = Path(__file__).parents[1]
PAGES = ROOT / "build" / "site-pages"
EXAMPLES = ROOT / "spec" / "examples"
WHOLE = ("docs", "LICENSES", "generated/kiln")
SINGLE = ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "LICENSE", "examples/max31865/README.md")
FOLDERS = re.compile(r"\]\(((?:\.\./)?(?:spec/examples|examples/max31865))\)")
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
    examples = _examples()
    described = schema()
    (PAGES / SCHEMA).write_text(json.dumps(described, indent=2, ensure_ascii=False), "utf-8")
    (PAGES / "kinds").mkdir()
    names = []
    for kind, definition in sorted(_kinds(described)):
        (PAGES / "kinds" / f"{kind}.md").write_text(_page(kind, definition, examples), "utf-8")
        names.append(kind)
    listed = "\n".join(f"- [{name}]({name}.md)" for name in names)
    (PAGES / "kinds" / "README.md").write_text(f"# Kinds\n\n{listed}\n", encoding="utf-8")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--clean"]
    quiet = os.environ | {"NO_MKDOCS_2_WARNING": "1"}
    return subprocess.run(command, cwd=ROOT, env=quiet, check=False).returncode  # noqa: S603


def _examples() -> dict[str, set[str]]:
    """Write a page for each example; return the kinds in it."""
    folder = PAGES / "spec" / "examples"
    folder.mkdir(parents=True)
    found, rows = {}, []
    for path in sorted(EXAMPLES.glob("*.yaml")):
        controller = load(path).controller
        title = controller.identity.title or controller.identity.name
        text = path.read_text(encoding="utf-8")
        shutil.copy(path, folder)
        (folder / f"{path.stem}.md").write_text(f"# {title}\n\n```yaml\n{text}```\n", "utf-8")
        rows.append(f"| [{path.stem}]({path.stem}.md) | {title} | {controller.identity.board} |")
        found[path.stem] = set(re.findall(r"kind: (\w+)", text))
    head = "# Examples\n\n| spec | machine | board |\n|---|---|---|\n"
    (folder / "README.md").write_text(head + "\n".join(rows) + "\n", encoding="utf-8")
    return found


def _kinds(described: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Find the models that have a kind."""
    for definition in described["$defs"].values():
        kind = definition["properties"].get("kind", {}).get("const")
        if kind is not None:
            yield kind, definition


def _page(kind: str, definition: dict[str, Any], examples: dict[str, set[str]]) -> str:
    """Describe a kind by its model: keys, defaults, meanings; and where it is used."""
    rows = [
        f"| `{key}` | {_default(key, each, definition)} | {each.get('description', '')} |"
        for key, each in definition["properties"].items()
        if key != "kind"
    ]
    used = [f"[{name}](../spec/examples/{name}.md)" for name in examples if kind in examples[name]]
    parts = [
        f"# {kind}",
        definition["description"],
        "| key | default | meaning |\n|---|---|---|\n" + "\n".join(rows),
        "[The language](../docs/language.md) tells which values a key takes.",
        f"Used in: {', '.join(used)}." if used else "No example uses it.",
    ]
    return "\n\n".join(parts) + "\n"


def _default(key: str, described: dict[str, Any], definition: dict[str, Any]) -> str:
    if key in definition.get("required", ()):
        return "needed"
    return f"`{json.dumps(described['default'])}`" if "default" in described else "none"


if __name__ == "__main__":
    sys.exit(main())
