"""Finds what a kind still lacks: each missing piece, with its file."""

import ast
from collections.abc import Iterator
from importlib import import_module
from importlib.resources import files
from importlib.resources.abc import Traversable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from pydantic import BaseModel

import heatwright.spec as language
from heatwright.generator import plan_firmware, render
from heatwright.spec import Controller, Spec, SpecError, kinds, load_text
from heatwright.spec.registry import LAYERS, KindIncomplete, brought, file_of, place_of

UNIONS = {role: getattr(language, role.capitalize()) for role in LAYERS if role != "board"}
EXAMPLE = "example.yaml"
UNFINISHED = "#error"
"""Mark of a template that is still to be written."""
_OF_LOOPS = {"cut", "mend"}
"""Functions that disconnect and connect a loop's sensor; a current sensor does not need them."""
SHARES = (0.2, 0.5, 0.8)
"""Temperatures at which a thermometer's reference model is tried, as shares of its range."""


def lacking(role: str, kind: str) -> Iterator[str]:
    """List what a kind lacks, one line for each piece: the file, and what it lacks.

    role -- sensor, output, algorithm, interface, plant; kind -- as a spec names it.
    """
    package = brought(role).get(kind)
    if package is not None and package.problem:
        yield package.problem
        return
    model = kinds(UNIONS[role]).get(kind)
    if model is None:
        yield f"pyproject.toml: no entry point {role}.{kind} in heatwright.kinds that is installed"
        return
    found = [*_lacking_in_model(role, model), *_lacking_files(role, kind, model)]
    if package is not None:
        found += _unfinished(package.package)
        found += () if found else _lacking_in_example(role, kind, package.package)
    yield from dict.fromkeys(found)


def _lacking_in_model(role: str, model: type[BaseModel]) -> Iterator[str]:
    file = file_of(model.__module__)
    if not model.__doc__:
        yield f"{file}: {model.__name__} has no docstring, which the schema shows"
    for name, field in model.model_fields.items():
        if name != "kind" and not (field.description or "").endswith("."):
            yield f"{file}: {model.__name__}.{name} has no description with a full stop"
    for name in sorted(_attributes_of_all(role, model) - _attributes(model)):
        yield f"{file}: {model.__name__} does not define {name}, as every similar {role} does"


def _attributes_of_all(role: str, model: type[BaseModel]) -> set[str]:
    """Return the attributes that all of heatwright's own models of the same group define."""
    own = [each for kind, each in kinds(UNIONS[role]).items() if kind not in brought(role)]
    alike = [each for each in own if _group(each) == _group(model)]
    return set.intersection(*map(_attributes, alike or own))


def _group(model: type[BaseModel]) -> tuple[object, ...]:
    """Return a model's group: what a sensor must define depends on its input and quantity."""
    return tuple(getattr(model, name, None) for name in ("on_adc", "measures_current"))


def _attributes(model: type[BaseModel]) -> set[str]:
    names = {*dir(model), *model.model_fields} - set(dir(BaseModel))
    return {name for name in names if not name.startswith("_")}


def _lacking_files(role: str, kind: str, model: type[BaseModel]) -> Iterator[str]:
    for layer in LAYERS[role]:
        name = place_of(role, layer, kind)
        left_out = _OF_LOOPS if getattr(model, "measures_current", False) else set()
        given = set(layer.gives) - left_out
        if find_spec(name) is None:
            wanted = " and ".join(sorted(given))
            missing = f"the {layer.what}, which must define {wanted}"
            yield f"{file_of(name)}: the file is missing: {missing}"
            continue
        try:
            module = import_module(name)
        except ImportError as error:
            yield f"{file_of(name)}: it cannot be imported: {error}"
            continue
        for each in sorted(given - set(dir(module))):
            yield f"{file_of(name)}: the {layer.what} lacks {each}"


def _unfinished(package: str) -> Iterator[str]:
    """Find functions and templates that are marked as still to be written."""
    folder = files(package)
    for file in _all(folder):
        text = file.read_text(encoding="utf-8")
        inner = Path(str(file)).relative_to(Path(str(folder)))
        found = _functions(text) if file.name.endswith(".py") else _marked(text)
        for number, what in sorted(found):
            yield f"{package.replace('.', '/')}/{inner}:{number}: {what} is still to be written"


def _functions(text: str) -> Iterator[tuple[int, str]]:
    """Yield line and name of each function that raises NotImplementedError."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef) and any(
            ast.unparse(each) == "raise NotImplementedError" for each in node.body
        ):
            yield node.lineno, node.name


def _marked(text: str) -> Iterator[tuple[int, str]]:
    """Yield line and text of each `#error` in a template."""
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith(UNFINISHED):
            yield number, line.removeprefix(UNFINISHED).strip(' "')


def _all(folder: Traversable) -> Iterator[Traversable]:
    for each in sorted(folder.iterdir(), key=lambda entry: entry.name):
        if each.is_dir():
            yield from _all(each)
        elif each.name.endswith((".py", ".j2")):
            yield each


def _lacking_in_example(role: str, kind: str, package: str) -> Iterator[str]:
    where = f"{package.replace('.', '/')}/{EXAMPLE}"
    file = files(package) / EXAMPLE
    if not file.is_file():
        yield f"{where}: the file is missing; it must be a spec that uses {kind}"
        return
    try:
        spec = load_text(file.read_text(encoding="utf-8"), where)
        render(plan_firmware(spec))
    except (SpecError, KindIncomplete) as error:
        yield f"{where}: {error}"
        return
    used = [each for each in _used(role, spec) if each.kind == kind]
    if not used:
        yield f"{where}: it does not use {kind}"
    if spec.controller.simulation is None:
        yield f"{where}: it has no simulation, and cannot be verified without one"
    for sensor in used if role == "sensor" else ():
        yield from _lacking_in_reference(sensor, spec.controller, package)


def _used(role: str, spec: Spec) -> list[Any]:
    controller = spec.controller
    plants = [controller.simulation.plant] if controller.simulation else []
    used: dict[str, list[Any]] = {
        "sensor": [*controller.sensors.values()],
        "output": [*controller.outputs.values()],
        "algorithm": [loop.algorithm for loop in controller.loops.values()],
        "interface": [*controller.interfaces],
        "plant": plants,
    }
    return used[role]


def _lacking_in_reference(sensor: Any, controller: Controller, package: str) -> Iterator[str]:
    """Check the reference model: readings of an ideal sensor convert back to its temperature."""
    if sensor.measures_current:
        return
    module = import_module(f"{package}.reference")
    convert = module.converter(sensor, controller.board)
    ideal = module.IdealSensor(sensor, controller.board)
    low_c, high_c = sensor.range_c
    for share in SHARES:
        felt_c = low_c + share * (high_c - low_c)
        status, raw = ideal.read(felt_c)
        allowed_k = sensor.error_k(felt_c) + sensor.step_at_k(felt_c, controller.board.mcu)
        where = file_of(module.__name__)
        if status:
            yield f"{where}: at {felt_c:g} °C the reading is not valid: status {status}"
        elif abs(float(convert(raw)) - felt_c) > allowed_k:
            yield f"{where}: at {felt_c:g} °C the reading {raw} converts to {convert(raw):g} °C"
