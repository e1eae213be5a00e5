"""Same spec, same bytes: no date, version, path or hash order, and a banner first."""

import datetime
import hashlib
import os
import re
import subprocess
import sys
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

import pytest
from rig.specs import files_of

from heatwright.generator.plan.parts import MARK

EXAMPLES = Path(__file__).parents[2] / "spec" / "examples"
PRINT_DIGEST = """
import hashlib, sys
from heatwright.generator import plan_firmware, render
from heatwright.spec import load
for name in sys.argv[1:]:
    files = render(plan_firmware(load(name)))
    print(hashlib.sha256(repr(list(files.items())).encode()).hexdigest())
"""


def sha256(files: Mapping[str, str]) -> str:
    return hashlib.sha256(repr(list(files.items())).encode()).hexdigest()


@pytest.mark.parametrize("seed", ["0", "1", "4294967295"])
def test_hash_order_does_not_show(seed: str, tmp_path: Path) -> None:
    specs = sorted(EXAMPLES.glob("*.yaml"))
    copies = [tmp_path / spec.name for spec in specs]
    for spec, copy in zip(specs, copies, strict=True):
        copy.write_bytes(spec.read_bytes())
    done = subprocess.run(
        [sys.executable, "-c", PRINT_DIGEST, *copies],
        env=os.environ | {"PYTHONHASHSEED": seed, "TZ": f"UTC{int(seed) % 9}", "LC_ALL": "C"},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    here = [sha256(files_of(spec.stem)) for spec in specs]
    assert done.stdout.split() == here


@pytest.mark.parametrize("spec", sorted(EXAMPLES.glob("*.yaml")), ids=lambda path: path.stem)
def test_nothing_of_the_day_or_the_machine_shows(spec: Path) -> None:
    files = files_of(spec.stem)
    assert list(files) == sorted(files)
    words = [str(Path.home()), str(Path.cwd()), os.uname().nodename, version("jinja2")]
    for path, text in files.items():
        assert not re.search(r"\b20[0-9]{2}-[01][0-9]-[0-3][0-9]\b", text), path
        assert f"{datetime.datetime.now(datetime.UTC):%b %d %Y}" not in text, path
        assert "__DATE__" not in text
        assert "__TIME__" not in text
        assert f"heatwright {version('heatwright')}" not in text, path
        assert not re.search(r"""["'\s(]/(?:home|usr|tmp|root|etc|opt)/""", text), path
        for word in words:
            assert word not in text, (path, word)


def test_every_file_begins_with_the_banner(chamber_files: Mapping[str, str]) -> None:
    said = f"{MARK} from chamber.yaml: edit that file, not this one. SPDX-License-Identifier: MIT-0"
    signs = {".ini": f"; {said}", ".md": f"<!-- {said} -->"}
    for path, text in chamber_files.items():
        assert text.partition("\n")[0] == signs.get(Path(path).suffix, f"// {said}"), path


def test_every_file_is_tidy(chamber_files: Mapping[str, str]) -> None:
    for path, text in chamber_files.items():
        assert text.endswith("\n"), path
        assert not text.endswith("\n\n"), path
        assert "\t" not in text, path
        assert "\r" not in text, path
        assert not re.search(r"[ ]$", text, re.MULTILINE), path
        assert "\n\n\n" not in text, path
        assert "{%" not in text, path
        assert "//%" not in text, path
        if path.endswith((".c", ".h")):
            assert text.isascii(), path
