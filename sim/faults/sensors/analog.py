"""Faults of a sensor of kind `analog`: see heatwright.sim.faults.analog."""

from heatwright.sim.faults.analog import cut, faults, mend

__all__ = ["cut", "faults", "mend"]
