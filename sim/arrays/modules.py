"""The translated modules of the model, by the names of the originals."""

import __future__

import ast
import builtins
import sys
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

from heatwright.sim.arrays import masks
from heatwright.sim.arrays.builtin import BUILTINS, Bisect, Math
from heatwright.sim.arrays.stack import ON_ARRAYS
from heatwright.sim.arrays.translate import translated
from heatwright.spec.registry import owned

_TRANSLATED = ("heatwright.sim.reference", "heatwright.sim.coupling")
_INSTEAD: dict[str, Any] = {"math": Math(), "bisect": Bisect()}


@cache
def on_arrays(name: str) -> ModuleType:
    """Return the translation of a module of the model; any other module unchanged.

    Raises ModuleNotFoundError: there is no such module.
    """
    if not _is_translated(name):
        return import_module(name)
    spec = find_spec(name)
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError(name)
    tree = translated(ast.parse(Path(spec.origin).read_text("utf-8")))
    code = compile(tree, spec.origin, "exec", __future__.annotations.compiler_flag)
    module = ModuleType(name + ON_ARRAYS)
    sys.modules[module.__name__] = module  # NamedTuple and typing look it up
    known = {**vars(builtins), **BUILTINS, "__import__": _import}
    module.__dict__.update(__builtins__=known, _lanes=masks)
    exec(code, module.__dict__)  # noqa: S102 - the model's own source
    return module


def _is_translated(name: str) -> bool:
    return name.startswith(_TRANSLATED) or owned(name, "reference")


def _import(
    name: str, _globals: object, _locals: object, wanted: tuple[str, ...] | None, level: int
) -> Any:
    assert not level  # noqa: S101 - all imports here are absolute
    if name in _INSTEAD:
        return _INSTEAD[name]
    if name == "importlib":
        return SimpleNamespace(import_module=on_arrays)
    if wanted and _is_translated(name):
        return on_arrays(name)
    return __import__(name, None, None, wanted or (), 0)
