"""Faults of a sensor of kind `analog`: see heatwright.sim.faults.analog."""

from heatwright.sim.faults.analog import faults

__all__ = ["faults"]
