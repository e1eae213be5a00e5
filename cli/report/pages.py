"""Renders a page from its template, with style and script inside."""

from __future__ import annotations

import json
from base64 import b64encode
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

if TYPE_CHECKING:
    from heatwright.spec import Spec

FOLDER = "heatwright.cli.report"


@cache
def _environment() -> Environment:
    return Environment(
        loader=PackageLoader("heatwright.cli", "report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def page(template: str, title: str, **names: Any) -> str:
    """Return the HTML of a page."""
    text: str = (
        _environment()
        .get_template(template)
        .render(title=title, style=_own("style.css"), script=_own("chart.js"), **names)
    )
    return text


def picture(png: bytes | None) -> str | None:
    """Return a picture as a `data:` address, so that the page contains it."""
    return None if png is None else f"data:image/png;base64,{b64encode(png).decode()}"


def wiring(spec: Spec) -> Markup:
    """Draw how the board is wired, as in the README of its project."""
    from heatwright.generator import plan_firmware  # noqa: PLC0415 - not every page has a wiring
    from heatwright.generator.plan.documents.readme import ReadmeNames  # noqa: PLC0415

    told = {file.path: file.told for file in plan_firmware(spec).files}["wiring.svg"]
    assert isinstance(told, ReadmeNames)  # noqa: S101 - the README shows it, too
    return Markup(told.wires)  # noqa: S704 - an SVG


def data(value: object) -> Markup:
    """Write a value as JSON that cannot end its script element."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False, ensure_ascii=False)
    return Markup(text.replace("<", "\\u003c"))  # noqa: S704 - without "<" it has no markup


def _own(name: str) -> Markup:
    return Markup(files(FOLDER).joinpath(name).read_text(encoding="utf-8"))  # noqa: S704 - ours
