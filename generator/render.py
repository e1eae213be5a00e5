"""Render the templates with the values of a plan. Nothing is decided or computed here."""

import json
import re
from collections.abc import Mapping
from dataclasses import fields
from functools import cache
from importlib.resources import files
from pathlib import Path, PurePosixPath

from jinja2 import Environment, FunctionLoader, StrictUndefined

from heatwright.generator.compiled import CompiledTemplates
from heatwright.generator.plan import Plan
from heatwright.generator.plan.parts import Told
from heatwright.spec.registry import KindIncomplete

_STATEMENT_LINE = re.compile(r"^[ \t]*//% (.*)$", re.MULTILINE)
_GUARD = re.compile(r"^#ifndef (\w+)\n#define \1$|^#pragma once$", re.MULTILINE)
_COMMENTS = {
    ".ini": "; {}\n",
    **dict.fromkeys((".md", ".svg", ".xml"), "<!-- {} -->\n"),
    **dict.fromkeys((".csv", ".hal", ".py"), "# {}\n"),
    ".json": '{{"_": "{}",\n',
}
"""Form of the banner by a file's suffix: a comment; in JSON, which has no comments, a member."""


def _load(template: str) -> str:
    """Read a template, with its `//%` lines converted to statements.

    Jinja's own line statements would remove the empty lines after them. Raises KindIncomplete: a
    package from outside lacks a template of its own, `package:name`.
    """
    package, _, name = template.rpartition(":")
    folder = files(package) / "templates" if package else files("heatwright.templates")
    file = folder / name
    if package and not file.is_file():
        raise KindIncomplete(
            f"A template is missing: write {package.replace('.', '/')}/templates/{name}."
        )
    text = file.read_text(encoding="utf-8")
    return _STATEMENT_LINE.sub(r"{% \1 %}", text)


@cache
def _environment() -> Environment:
    return Environment(
        loader=FunctionLoader(_load),
        undefined=StrictUndefined,
        autoescape=False,  # noqa: S701 - C is no HTML; the plan escapes text from the spec
        bytecode_cache=_compiled(),
        keep_trailing_newline=True,
        trim_blocks=True,
    )


@cache
def _compiled() -> CompiledTemplates:
    return CompiledTemplates(Path(str(files("heatwright.templates"))), "trim_blocks")


def _begun(suffix: str, banner: str) -> str:
    inside = json.dumps(banner)[1:-1] if suffix == ".json" else banner
    return _COMMENTS.get(suffix, "// {}\n").format(inside)


def _guarded(path: PurePosixPath, text: str) -> str:
    """Return a text; add an include guard after a header's first comment, unless it has a guard."""
    if path.suffix != ".h" or _GUARD.search(text):
        return text
    guard = f"{path.stem.upper()}_H"
    comment, end, rest = text.partition("*/\n") if text.startswith("/*") else ("", "", text)
    return f"{comment}{end}#ifndef {guard}\n#define {guard}\n{rest.rstrip()}\n\n#endif\n"


def names(told: Told) -> dict[str, object]:
    """Return a template's variables by name; nested dataclasses stay whole."""
    if isinstance(told, Mapping):
        return dict(told)
    if isinstance(told, tuple):
        return {name: value for each in told for name, value in names(each).items()}
    return {each.name: getattr(told, each.name) for each in fields(told)}


def render(plan: Plan) -> Mapping[str, str]:
    """Return the text of every file by its path in the project, in the order of the paths."""
    environment = _environment()
    texts = {}
    for file in plan.files:
        path = PurePosixPath(file.path)
        text = environment.get_template(file.template).render(names(file.told))
        texts[file.path] = _begun(path.suffix, plan.banner) + _guarded(path, text)
    _compiled().save()
    return texts
