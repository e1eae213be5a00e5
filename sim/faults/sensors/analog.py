"""Faults of a sensor of kind `analog`: see heatwright.sim.faults.sensing.analog."""

from heatwright.sim.faults.sensing.analog import cut, faults, mend

__all__ = ["cut", "faults", "mend"]
