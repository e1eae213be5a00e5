"""Faults of a MAX31855, which also reports a thermocouple shorted to ground or supply."""

from collections.abc import Iterator
from typing import cast

from heatwright.sim.faults.fault import Act, Fault
from heatwright.sim.faults.sensing import converter
from heatwright.sim.faults.sensing.converter import chip_of, cut, mend
from heatwright.sim.faults.sensing.readings import no_reading
from heatwright.sim.faults.world import Site, World
from heatwright.sim.sensors.max31855 import Max31855
from heatwright.sim.sensors.spi_chip import Wire

__all__ = ["cut", "faults", "mend"]


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of the loop's MAX31855."""
    yield from converter.faults(site)
    wires: tuple[Wire, ...] = ("ground", "supply")
    for wire in wires:
        name = f"thermocouple_touches_{wire}"
        yield no_reading(site, name, _touch(wire), _touch(None))
    yield converter.slow(site)


def _touch(wire: Wire | None) -> Act:
    def act(world: World) -> None:
        cast("Max31855", chip_of(world)).shorted_to = wire

    return act
