"""Faults of a sensor of kind `rtd`: see heatwright.sim.faults.analog."""

from heatwright.sim.faults.analog import CUT_RULE, cut, faults, mend

__all__ = ["CUT_RULE", "cut", "faults", "mend"]
