"""Finds the modules of a kind, whether heatwright's own or of a package installed beside it.

Such a package declares each of its kinds, with the kind's model, by an entry point:

    [project.entry-points."heatwright.kinds"]
    "sensor.max31865" = "heatwright_max31865.model:Max31865"

The kind's other modules are beside its model (docs/extending.md).
"""

import os
import sys
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from typing import Annotated, Any, NamedTuple, Union, get_args

GROUP = "heatwright.kinds"
_HEADING = f"[{GROUP}]".encode()


class Layer(NamedTuple):
    """One of the modules of a kind.

    stem -- name of its file in a package from outside; package -- heatwright's own package of such
    modules, each named after its kind; what -- its description in messages; gives -- the names that
    it must define; shared -- modules that each serve several of heatwright's kinds, which `KINDS`
    in the module lists.
    """

    stem: str
    package: str
    what: str
    gives: tuple[str, ...]
    shared: tuple[str, ...] = ()


def _plan(folder: str) -> Layer:
    return Layer("plan", f"heatwright.generator.plan.{folder}", "plan of its firmware", ("plan",))


def _simulated(folder: str, *shared: str) -> Layer:
    package = f"heatwright.sim.{folder}"
    return Layer("simulated", package, "simulation at its pins", ("attach",), shared)


def _reference(folder: str, gives: tuple[str, ...], *shared: str) -> Layer:
    package = f"heatwright.sim.reference.{folder}"
    return Layer("reference", package, "reference model", gives, shared)


LAYERS = {
    "sensor": (
        _plan("sensors"),
        _simulated("sensors", "heatwright.sim.sensors.adc_sensor"),
        _reference("sensors", ("converter", "IdealSensor"), "heatwright.sim.reference.sensors.adc"),
        Layer(
            "faults",
            "heatwright.sim.faults.sensors",
            "faults",
            ("faults", "cut", "mend"),
            ("heatwright.sim.faults.sensing.analog", "heatwright.sim.faults.sensing.converter"),
        ),
    ),
    "output": (_plan("outputs"), _simulated("outputs", "heatwright.sim.outputs.switch")),
    "algorithm": (_plan("algorithms"), _reference("algorithms", ("Control",))),
    "interface": (
        _plan("interfaces"),
        _simulated("interfaces"),
        Layer("seat", "heatwright.cli.bench.parts", "place at the bench", ("take",)),
    ),
    "plant": (Layer("plant", "heatwright.sim.plants", "simulated machine", ("Plant",)),),
    "board": (),
}
"""The modules that a kind has beside its model, by its role: sensor, output and so on."""


class Brought(NamedTuple):
    """A kind that a package beside heatwright provides.

    package -- where its modules are; value -- what its entry point names: the model, or the parts
    of a board; problem -- why it cannot be used, if that is so.
    """

    package: str
    value: Any = None
    problem: str = ""


class KindIncomplete(Exception):
    """A kind lacks a module."""


@cache
def brought(role: str) -> dict[str, Brought]:
    """Return the kinds of a role that packages provide, by name, also those that cannot be used."""
    found: dict[str, Brought] = {}
    for name, place in _entry_points():
        its_role, _, kind = name.partition(".")
        if its_role == role:
            one = _loaded(role, kind, place)
            found[kind] = _twice(kind, found[kind], one) if kind in found else one
    return found


def misnamed() -> list[str]:
    """Report entry points whose names begin with no role."""
    return [
        f'pyproject.toml: "{name}" = "{place}" begins with none of {", ".join(LAYERS)}'
        for name, place in _entry_points()
        if name.partition(".")[0] not in LAYERS
    ]


def usable(role: str) -> dict[str, Any]:
    """Return the objects that the entry points of a role name, by kind; only usable ones."""
    return {kind: each.value for kind, each in brought(role).items() if not each.problem}


def with_brought(role: str, union: Any) -> Any:
    """Return a discriminated union of models, extended by those that packages provide."""
    if not brought(role):
        return union
    own, *marks = get_args(union)
    names = set(map(kind_of, get_args(own) or [own]))
    for kind in names & set(brought(role)):
        package = brought(role)[kind].package
        taken = f"{package} provides the {role} kind {kind}, which heatwright has itself"
        brought(role)[kind] = Brought(package, problem=taken)
    return Annotated[Union[own, *usable(role).values()], *marks]


def problem_of_kind(kind: str) -> str:
    """Report why a kind from a package cannot be used; nothing if there is no such kind."""
    found = (brought(role).get(kind) for role in LAYERS)
    return next((each.problem for each in found if each and each.problem), "")


def module_of(role: str, stem: str, kind: str) -> str:
    """Return the name of a kind's module.

    role -- sensor, output, algorithm, interface, plant; stem -- of its layer: plan, simulated,
    reference, faults; kind -- as a spec names it. Raises KindIncomplete: there is no such module;
    the message says which file to write.
    """
    layer = next(each for each in LAYERS[role] if each.stem == stem)
    name = place_of(role, layer, kind)
    if name not in sys.modules and not _is_there(name):
        raise KindIncomplete(
            f"The {role} kind {kind} has no {layer.what}: write {file_of(name)}, which must define "
            f"{' and '.join(layer.gives)}."
        )
    return name


def place_of(role: str, layer: Layer, kind: str) -> str:
    """Return the name that a kind's module has, or is to have."""
    outside = brought(role).get(kind)
    if outside is not None and not outside.problem:
        return f"{outside.package}.{layer.stem}"
    serving = (name for name in layer.shared if kind in import_module(name).KINDS)
    return next(serving, f"{layer.package}.{kind}")


def file_of(module: str) -> str:
    """Return the file of a module, below the folder that its package is in."""
    return f"{module.replace('.', '/')}.py"


def owned(module: str, stem: str) -> bool:
    """Return whether a module is the layer `stem` of a kind from outside."""
    return module in {f"{package}.{stem}" for package in packages()}


def packages() -> list[str]:
    """Return the packages that provide kinds."""
    return sorted({each.package for role in LAYERS for each in brought(role).values()})


def _is_there(module: str) -> bool:
    try:
        return find_spec(module) is not None
    except ModuleNotFoundError:
        return False


def _loaded(role: str, kind: str, place: str) -> Brought:
    """Import the object of an entry point; a broken package must not stop the others."""
    module, _, name = place.partition(":")
    package = module.rpartition(".")[0]
    try:
        value = getattr(import_module(module), name)
        said = kind if role == "board" else kind_of(value)
    except Exception as error:  # a package may raise anything
        return Brought(package, problem=f"{place} cannot be imported ({error})")
    wrong = f"{place} is of the kind {said}, but its entry point names the kind {kind}"
    return Brought(package, value, wrong if said != kind else "")


def kind_of(model: Any) -> str:
    """Return the kind that a model is for."""
    return str(get_args(model.model_fields["kind"].annotation)[0])


def _twice(kind: str, first: Brought, second: Brought) -> Brought:
    both = f"{first.package} and {second.package} both provide {kind}"
    return Brought(first.package, problem=f"{both}: remove one of them")


@cache
def _entry_points() -> tuple[tuple[str, str], ...]:
    """Find heatwright's entry points: name and object, in the order of the names.

    Importing importlib.metadata would take 15 ms, as long as the rest of `check --quick`.
    """
    found = {point for text in _metadata() if _HEADING in text for point in _listed(text.decode())}
    return tuple(sorted(found))


def _metadata() -> Iterator[bytes]:
    """Read the entry points of everything that is installed."""
    for folder in sys.path:
        try:
            entries = list(os.scandir(folder or "."))
        except OSError:  # it is an archive, or does not exist
            continue
        for entry in entries:
            if entry.name.endswith((".dist-info", ".egg-info")):
                try:
                    place = os.open(f"{entry.path}/entry_points.txt", os.O_RDONLY)
                except OSError:
                    continue
                with os.fdopen(place, "rb") as file:
                    yield file.read()


def _listed(text: str) -> Iterator[tuple[str, str]]:
    inside = False
    for line in text.splitlines():
        if line.startswith("["):
            inside = line.strip() == f"[{GROUP}]"
        elif inside and "=" in line:
            name, _, place = line.partition("=")
            yield name.strip(), place.strip()
