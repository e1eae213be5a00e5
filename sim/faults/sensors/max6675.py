"""A MAX6675's faults, and those of its thermocouple and wires."""

from heatwright.sim.faults.converter import CUT_RULE, cut, faults, mend

__all__ = ["CUT_RULE", "cut", "faults", "mend"]
