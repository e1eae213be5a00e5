"""Faults of a MAX6675, its thermocouple and its wires."""

from heatwright.sim.faults.sensing.converter import cut, faults, mend

__all__ = ["cut", "faults", "mend"]
