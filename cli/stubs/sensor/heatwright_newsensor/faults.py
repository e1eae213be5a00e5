"""A newsensor's faults: what can go wrong with it, its supply and its wires."""

from __future__ import annotations

from collections.abc import Iterator

from heatwright.sim.faults.fault import Fault
from heatwright.sim.faults.sensing.readings import no_reading
from heatwright.sim.faults.world import Site, World


def cut(world: World) -> None:
    """Disconnect the sensor, `world.device.sensors[world.site.loop.sensor]`."""
    raise NotImplementedError


def mend(world: World) -> None:
    """Connect it again."""
    raise NotImplementedError


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of the loop's sensor."""
    yield no_reading(site, "unplugged", cut, mend)
