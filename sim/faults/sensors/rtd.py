"""Faults of a sensor of kind `rtd`: see heatwright.sim.faults.analog."""

from heatwright.sim.faults.analog import faults

__all__ = ["faults"]
