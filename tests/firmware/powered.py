from collections.abc import Callable

from heatwright.sim.device import AvrDevice

PowerOn = Callable[..., AvrDevice]
