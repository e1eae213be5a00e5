"""What a spec makes of the templates: those it uses, and what each of their conditions was."""

import re
from functools import cache
from typing import Any

from jinja2 import Environment, FunctionLoader, StrictUndefined, nodes

from heatwright.generator import plan_firmware
from heatwright.generator.render import _load
from heatwright.spec import Spec


class _Noting(Environment):
    """Tells of each condition, wherever one stands in a template, whether it was true."""

    def __init__(self) -> None:
        super().__init__(
            loader=FunctionLoader(_load), undefined=StrictUndefined, trim_blocks=True
        )  # as the generator's own
        self.places: dict[str, tuple[str, str]] = {}
        """Template and condition by place."""
        self.seen: set[tuple[str, bool]] = set()
        self.globals["noted"] = self._noted

    def _noted(self, place: str, value: Any) -> Any:
        self.seen.add((place, bool(value)))
        return value

    def _parse(self, source: str, name: str | None, filename: str | None) -> nodes.Template:
        tree = super()._parse(source, name, filename)
        asked = [each for each in tree.find_all((nodes.If, nodes.CondExpr, nodes.For)) if each.test]
        for number, each in enumerate(asked):
            place = f"{name}:{each.lineno}:{number}"
            self.places[place] = str(name), _text_of(source, each)
            known = nodes.Name("noted", "load")
            each.test = nodes.Call(known, [nodes.Const(place), each.test], [], None, None)
        return tree


def _text_of(source: str, asked: nodes.If | nodes.CondExpr | nodes.For) -> str:
    """Give a condition as it stands in the template, as far as a line of its own tells it."""
    line = source.splitlines()[asked.lineno - 1]
    alone = re.fullmatch(r"{% (?:el)?if (.+) %}", line.strip())
    return alone[1] if alone else line.strip()


@cache
def noting() -> _Noting:
    """Return the one environment: compiling the templates takes a while."""
    return _Noting()


def shown(spec: Spec) -> frozenset[object]:
    """Render all files of a spec; return its templates and what their conditions were."""
    environment = noting()
    environment.seen = set()
    files = plan_firmware(spec).files
    for file in files:
        environment.get_template(file.template).render(file.context)
    return frozenset({*(file.template for file in files), *environment.seen})
