"""Faults of machine, sensor, processor and operator, and what must follow each."""

from heatwright.sim.faults.catalogue import catalogue
from heatwright.sim.faults.fault import Fault, FaultResult
from heatwright.sim.faults.procedure import try_fault

__all__ = ["Fault", "FaultResult", "catalogue", "try_fault"]
