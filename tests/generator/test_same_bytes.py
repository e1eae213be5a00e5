"""Same spec, same bytes, here and committed: no date, version, path or hash order; and how many."""

import datetime
import hashlib
import os
import re
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest
from rig.specs import EXAMPLES, example, files_of

from heatwright.generator import compare, write
from heatwright.generator.plan.parts import MARK
from heatwright.generator.toolchain import build

GENERATED = Path(__file__).parents[2] / "generated"
NAMES = ("chamber", "extruder", "fabricator", "feeder", "kiln")
"""The examples whose firmware is committed."""
PRINT_DIGEST = """
import hashlib, sys
from heatwright.generator import plan_firmware, render
from heatwright.spec import load
for name in sys.argv[1:]:
    files = render(plan_firmware(load(name)))
    print(hashlib.sha256(repr(list(files.items())).encode()).hexdigest())
"""


@pytest.mark.parametrize("seed", ["0", "1", "4294967295"])
def test_hash_order_does_not_show(seed: str, tmp_path: Path) -> None:
    specs = sorted(EXAMPLES.glob("*.yaml"))
    copies = [tmp_path / spec.name for spec in specs]
    for spec, copy in zip(specs, copies, strict=True):
        copy.write_bytes(spec.read_bytes())
    done = subprocess.run(
        [sys.executable, "-c", PRINT_DIGEST, *copies],
        env=os.environ | {"PYTHONHASHSEED": seed, "TZ": f"UTC{int(seed) % 9}", "LC_ALL": "C"},
        cwd=tmp_path, capture_output=True, text=True, check=True,
    )  # fmt: skip
    texts = [repr(list(files_of(spec.stem).items())) for spec in specs]
    assert done.stdout.split() == [hashlib.sha256(text.encode()).hexdigest() for text in texts]


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


def test_every_file_begins_with_the_banner() -> None:
    said = f"{MARK} from chamber.yaml: edit that file, not this one. SPDX-License-Identifier: MIT-0"
    signs = {".ini": f"; {said}", ".md": f"<!-- {said} -->"}
    for path, text in files_of("chamber").items():
        assert text.partition("\n")[0] == signs.get(Path(path).suffix, f"// {said}"), path


def test_every_file_is_tidy() -> None:
    for path, text in files_of("chamber").items():
        assert text.endswith("\n"), path
        assert not re.search(r"\n\n\Z|\n\n\n|[\t\r]| $|\{%|//%", text, re.MULTILINE), path
        if path.endswith((".c", ".h")):
            assert text.isascii(), path


@pytest.mark.parametrize("name", NAMES)
def test_the_committed_firmware_is_current(name: str) -> None:
    files, folder = files_of(name), GENERATED / name
    assert compare(files, folder) == ()
    committed = {path.relative_to(folder).as_posix() for path in folder.rglob("*")}
    assert {path for path in committed if (folder / path).is_file()} == set(files)
    assert example(name).controller.identity.name == name


def test_nothing_else_is_committed() -> None:
    assert {path.name for path in GENERATED.iterdir()} == set(NAMES)


def test_the_chamber_takes_three_quarters_of_the_sketch_and_leaves_room(tmp_path: Path) -> None:
    """The sketch with its libraries takes 8826 bytes of flash and 345 of RAM, and protects less."""
    protection = example("chamber").controller.loops["air"].protection
    rules = (
        protection.heating, protection.runaway, protection.frozen, protection.rising_while_off
    )  # fmt: skip
    assert all(rules)
    write(files_of("chamber"), tmp_path)
    built = build(tmp_path)
    assert built.flash_bytes <= 6620
    assert built.ram_bytes <= 259
    assert built.ram_bytes + built.stack_bytes <= built.ram_limit
    assert built.flash_bytes <= built.flash_limit
