"""Compiled templates are kept, and what is kept is never wrong."""

import sys
from pathlib import Path

import pytest
from jinja2 import Environment, FunctionLoader

from heatwright.generator.compiled import CompiledTemplates


@pytest.fixture(autouse=True)
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    monkeypatch.setattr(sys, "pycache_prefix", None)
    return tmp_path / "__pycache__"


def rendered(folder: Path, source: str, options: str = "", **names: bool) -> str:
    cache = CompiledTemplates(folder, options)
    loader = FunctionLoader(lambda _: source)
    environment = Environment(loader=loader, bytecode_cache=cache, **names)  # type: ignore[arg-type]  # noqa: S701
    text = environment.get_template("t").render(x=1)
    cache.save()
    return text


def test_it_is_kept_in_one_file(tmp_path: Path, kept: Path) -> None:
    assert rendered(tmp_path, "a{{ x }}") == "a1"
    (file,) = kept.iterdir()
    before = file.stat().st_mtime_ns
    assert rendered(tmp_path, "a{{ x }}") == "a1"
    assert file.stat().st_mtime_ns == before
    # Another text, or other options, are compiled anew.
    source = "{% if x %}\n1{% endif %}"
    assert rendered(tmp_path, source) == "\n1"
    assert rendered(tmp_path, source, "trim_blocks", trim_blocks=True) == "1"
    assert rendered(tmp_path, source) == "\n1"


@pytest.mark.parametrize(
    "damaged", [b"", b"not marshal", b"\x00", b"i\x01\x00\x00\x00", None], ids=repr
)
def test_what_is_damaged_is_compiled_anew(
    tmp_path: Path, kept: Path, damaged: bytes | None
) -> None:
    rendered(tmp_path, "a{{ x }}")
    (file,) = kept.iterdir()
    file.write_bytes(file.read_bytes().replace(b"j2", b"j9") if damaged is None else damaged)
    assert rendered(tmp_path, "a{{ x }}") == "a1"


def test_where_nothing_can_or_may_be_written_nothing_is_kept(
    tmp_path: Path, kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept.write_text("in the way", encoding="utf-8")
    assert rendered(tmp_path, "a{{ x }}") == "a1"
    assert kept.read_text(encoding="utf-8") == "in the way"
    kept.unlink()
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    assert rendered(tmp_path, "a{{ x }}") == "a1"
    assert not kept.exists()
