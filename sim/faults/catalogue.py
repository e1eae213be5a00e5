"""Which faults apply to a controller, derived from the parts that it has."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import chain

from heatwright.sim.binary.elf import Elf
from heatwright.sim.faults import healthy
from heatwright.sim.faults.bounds import answer_s
from heatwright.sim.faults.controller import memory, processor
from heatwright.sim.faults.fault import Act, Fault, nothing
from heatwright.sim.faults.machine_parts import (
    coolers,
    efforts,
    heaters,
    inputs,
    monitors,
    proofs,
    relays,
    wires,
)
from heatwright.sim.faults.operation import displays, left_on, masters, operators, programs
from heatwright.sim.faults.sensing import any_sensor, second
from heatwright.sim.faults.world import Site
from heatwright.spec import Controller


def catalogue(controller: Controller, program: Elf) -> tuple[Fault, ...]:
    """Return all faults by loop; those of the whole controller are tried on the first loop.

    Faults of the memory are tried on the loop that trips soonest without its sensor, because some
    of them need a latched fault.

    Ids are unique; with several loops, the id of a loop's own fault begins with the loop's name.
    Raises ValueError: the spec has no simulated machine.
    """
    found: list[Fault] = []
    sites = [Site(controller, name, program) for name in controller.loops]
    quickest = min(sites, key=lambda site: answer_s(site.loop))
    for site in sites:
        prefix = _prefix(controller, site.loop_name)
        found += [replace(fault, id=f"{prefix}{fault.id}") for fault in _of_loop(site)]
        if site is sites[0]:
            found += _of_controller(site, quickest)
    return tuple(found)


def _prefix(controller: Controller, loop_name: str) -> str:
    """Return the prefix of the ids of a loop's own faults."""
    return f"{loop_name}." if len(controller.loops) > 1 else ""


def by_part(site: Site) -> dict[str, tuple[Fault, ...]]:
    """Return the faults of a loop, and those of the whole controller, by the part that fails."""
    parts = _parts_of_loop(site) | _parts_of_controller(site, site)
    return {part: tuple(faults) for part, faults in parts.items()}


def causes(controller: Controller, program: Elf) -> Iterator[tuple[str, str, Fault]]:
    """Yield the faults that `bench` can apply to a running machine: part, loop and fault.

    Only their cause and cure are used. If several faults have the same cause, only the first is
    yielded. Faults without a cause, which only watch a healthy machine, are left out.
    """
    known: set[Act] = {nothing}
    for number, name in enumerate(controller.loops):
        site, prefix = Site(controller, name, program), _prefix(controller, name)
        parts = [(prefix, part, found) for part, found in _parts_of_loop(site).items()]
        if number == 0:
            parts += [("", *each) for each in _parts_of_controller(site, site).items()]
        for before, part, found in parts:
            for fault in found:
                if fault.cause not in known:
                    known.add(fault.cause)
                    yield part, name, replace(fault, id=f"{before}{fault.id}")


def _of_loop(site: Site) -> list[Fault]:
    found = [*chain.from_iterable(_parts_of_loop(site).values()), *healthy.faults(site)]
    return [*left_on.over_meanwhile(site.controller, found), *left_on.faults(site)]


def _parts_of_loop(site: Site) -> dict[str, Iterable[Fault]]:
    """Return the faults of a loop by the part that fails."""
    return {
        "sensor": chain.from_iterable(
            memory.module_of_sensor(site, name).faults(site) for name in _sensors(site)
        ),
        "tip": any_sensor.faults(site),
        "second sensor": second.faults(site),
        "heater": heaters.faults(site),
        "effort": efforts.faults(site),
        "wire": wires.faults(site),
        "cooler": coolers.faults(site),
        "fan": proofs.faults(site),
        "program": programs.faults(site),
        "display": displays.faults(site),
    }


def _sensors(site: Site) -> list[str]:
    """Return the names of the loop's sensor and of the sensor of its heater's current."""
    current = site.facts.current
    return [site.loop.sensor, *([current.sensor] if current else [])]


def _of_controller(site: Site, quickest: Site) -> list[Fault]:
    found = chain.from_iterable(_parts_of_controller(site, quickest).values())
    return left_on.over_meanwhile(site.controller, list(found))


def _parts_of_controller(site: Site, quickest: Site) -> dict[str, Iterable[Fault]]:
    """Return the faults of the whole controller by the part that fails."""
    return {
        "processor": processor.faults(site),
        "relay": relays.faults(site),
        "input": inputs.faults(site),
        "monitor": monitors.faults(site),
        "memory": memory.faults(quickest),
        "operator": operators.faults(site),
        "master": masters.faults(site),
    }
