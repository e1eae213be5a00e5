"""The users of the simulated interfaces; each module is named after its kind of interface."""

from importlib import import_module

from heatwright.cli.bench.parts.seat import Seat
from heatwright.spec import Controller
from heatwright.spec.registry import module_of


def seats_of(controller: Controller) -> tuple[Seat, ...]:
    """Return a seat for each interface of a controller, in the order of the spec."""
    found = []
    for number, interface in enumerate(controller.interfaces):
        module = import_module(module_of("interface", "seat", interface.kind))
        found.append(module.take(controller, number))
    return tuple(found)
