"""A MAX6675's faults, and those of its thermocouple and wires."""

from heatwright.sim.faults.sensing.converter import cut, faults, mend

__all__ = ["cut", "faults", "mend"]
